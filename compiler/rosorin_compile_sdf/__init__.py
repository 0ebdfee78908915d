"""SDF: the robot for Gazebo and Drake, and robots that come as SDF. All of it is the format, ``sdf``."""
