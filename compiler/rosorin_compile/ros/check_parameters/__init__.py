"""Check ROS parameter files against a robot: keys of ``nodes``, published ``transforms``, controllers and topics."""
