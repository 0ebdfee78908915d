"""Write a new ROS 2 package with the artifacts of a robot, or deploy the artifacts into an existing package."""
