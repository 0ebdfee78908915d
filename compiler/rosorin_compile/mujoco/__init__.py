"""Export robots to MuJoCo, and run checks in MuJoCo.

The formats are ``mjcf`` and ``scene``. ``simulation`` tests poses, driving and joint ranges. ``physics`` finds
implausible masses and sizes, and overlapping links. ``collisions`` computes the collision matrix for MoveIt.
"""
