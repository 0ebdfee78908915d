"""The robot for ROS 2: parameter files, the SRDF, packages, and the parameter files of others.

Formats: ``controllers`` (ros2_control), ``nav2``, ``robot_localization``, ``srdf`` (MoveIt). ``package`` writes a
package and deploys into one, ``check_parameters`` checks parameter files of users against a robot.
"""
