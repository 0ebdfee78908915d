"""Packaging: write a new ROS 2 package with the artifacts, or deploy the artifacts into an existing package."""
