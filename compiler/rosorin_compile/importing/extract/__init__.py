"""Extract bounding shapes and height maps from meshes, and joint data from ROS description packages."""
