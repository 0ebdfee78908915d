"""The robot for MuJoCo, and what MuJoCo says of it.

Formats: ``mjcf`` and ``scene``. ``simulate`` lets a robot stand, hold, drive and fall. ``physics`` checks what no body
can be, and where links are inside each other. ``collisions`` finds the pairs of links that need no check.
"""
