"""Check ROS parameter files against a robot: their ``nodes``, their ``transforms``, and the ``check`` itself."""
