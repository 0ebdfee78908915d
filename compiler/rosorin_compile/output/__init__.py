"""Write files atomically: the artifacts of a robot, files in a ROS package, and single files."""
