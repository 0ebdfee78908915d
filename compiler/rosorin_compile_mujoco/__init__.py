"""What MuJoCo says of a robot, beside the MJCF that the core writes.

``simulate`` lets a robot stand, hold, drive and fall. ``physics`` checks what no body can be, and where links are
inside each other. ``collisions`` finds the pairs of links that need no check.
"""
