"""ROS 2 output of a robot: parameter files, the SRDF and packages, and checks of existing parameter files.

Formats: ``controllers`` (ros2_control), ``nav2``, ``robot_localization``, ``srdf`` (MoveIt). ``package`` writes a
ROS package or deploys into an existing one, ``check_parameters`` checks users' parameter files against a robot.
"""
