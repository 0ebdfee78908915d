"""Find the pairs of links that need no collision check, as MoveIt's setup assistant does.

The matrix is a file of the description: compiling the robot needs neither MuJoCo nor minutes, the result is the same on
every machine, and changes of it are visible where it is committed.
"""
