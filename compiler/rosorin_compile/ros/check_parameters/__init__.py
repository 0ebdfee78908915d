"""check parameters: the parameter files of a robot's nodes, held against its description.

To be read in this order: ``nodes`` (which nodes the files speak of, and what they are; the files and what is known of
nodes are in ``parameters``), ``values`` (keys and types),
``remaps`` (topics, also from launch files), ``owners`` (who publishes which edge), ``frames`` (the frames that are
named), ``checking`` (all of it, and what a controller and the robot say of each other).
"""
