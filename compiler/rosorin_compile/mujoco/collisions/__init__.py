"""rosorin-compile collisions: which pairs of links need no check, computed as MoveIt's assistant does.

``contacts`` asks MuJoCo who touches whom in one state, ``search`` tries the states and decides, ``command`` writes the
file that the description includes. The matrix is a file of the description: whoever compiles the robot needs neither
MuJoCo nor minutes, the same bytes come out on every machine, and a change of it is seen where it is committed.
"""
