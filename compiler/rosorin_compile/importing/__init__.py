"""Import existing robots as descriptions that read as if a person had written them.

``import_robot`` is the entry. ``description`` writes YAML, ``repeats`` writes repeated structures once, ``elements``
converts Gazebo and ros2_control elements, ``round_trip`` compares the description with the source, and ``xacro`` keeps
macros and arguments.
"""
