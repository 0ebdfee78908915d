"""The robot for ROS 2: parameter files, the SRDF, packages, and the parameter files of others.

Formats: ``controllers`` (ros2_control), ``nav2``, ``robot_localization``, ``srdf`` (MoveIt). ``navigation`` is what the
second and the third share, ``parameters`` what is known of the nodes. ``package`` writes a package and deploys into
one, ``check_parameters`` holds the parameter files of others against a robot.
"""
