"""Write files safely: the artifacts of a robot as one set, files of a ROS package, and single files."""
