"""Numbers from meshes: shapes around parts, height maps, and the numbers of a ROS description package."""
