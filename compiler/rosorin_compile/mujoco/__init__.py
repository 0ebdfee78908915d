"""Export to MuJoCo, and checks that run in MuJoCo.

Formats: ``mjcf`` and ``scene``. ``simulation`` simulates poses, driving and joints. ``physics`` finds implausible
masses and sizes, and overlapping links. ``collisions`` computes the collision matrix for MoveIt.
"""
