"""Parameters of ROS 2 nodes: what is known of them, and values held against that.

Formats write such parameters (``files``), and ``check --parameters`` reads those that people have. ``tables`` says
which kinds of nodes there are and which keys each has, ``values`` which values fit a type and what its validators
refuse, ``checking`` what is wrong with the parameters of one node.
"""
