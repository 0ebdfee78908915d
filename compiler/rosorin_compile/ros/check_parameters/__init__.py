"""Check ROS parameter files against a robot: parameters of nodes, published transforms, controllers and topics."""
