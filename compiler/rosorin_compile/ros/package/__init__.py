"""Packaging: a ROS 2 package made of the artifacts, and the artifacts put into a package that people already have."""
