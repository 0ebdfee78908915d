"""Convert the Gazebo and ros2_control elements of a URDF or SDF to sections of a description."""
