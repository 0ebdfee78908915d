"""Parameters of ROS 2 nodes: what is known of them, and values held against that.

Formats write such parameters, and ``check parameters`` reads those that people have: ``files``. ``tables`` has the
kinds of nodes with the keys of each and the values that these take, ``checking`` what is wrong with one node.
"""
