"""The sections of the language that nodes of ROS 2 read: hardware, controllers, planning."""
