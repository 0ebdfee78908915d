"""Import robots from URDF, xacro, SDF or MJCF files as YAML descriptions that are easy to read and edit.

``import_robot`` is the entry point. ``description`` writes the YAML, ``repeats`` moves repeated structures into
parts, ``elements`` converts Gazebo and ros2_control elements, ``round_trip`` compares the compiled description with the
source, and ``xacro`` translates macros and arguments.
"""
