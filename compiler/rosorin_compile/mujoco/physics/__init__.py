"""check physics: what takes an engine or meshes to be seen of a robot that cannot be.

``checking`` goes through it: ``files`` finds and reads the meshes, ``meshes`` holds them against masses, inertias and
each other, ``scene`` has the parts in MuJoCo and says which overlap at joint positions, ``overlaps`` what that means at
rest, ``sweeps`` over the ranges of the joints, and ``rest`` simulates a second from each pose.

All of it is about one robot; where a number was written is asked of the ``Case`` of the rules.
"""
