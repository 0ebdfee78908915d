"""Verify: recordings of a running robot held against its description.

A recording flows from file to file, in the order to read them:

1. ``sources`` tells what a source is and takes it through the rest.
2. ``expected`` says what the description lets one expect: its edges, and how exactly they are known.
3. ``bags`` reads what rosbag2 recorded, batch by batch; ``pasted`` what was pasted from a terminal.
4. ``recording`` keeps statistics of fixed size of what streams by.
5. ``judge`` holds them against what is expected; each thing that is wrong is one of the ``findings``.
6. A ``Verdict`` comes out; ``lines``, ``machine`` (JSON and JUnit XML) and ``picture`` show it.

``arrays`` is what all of them calculate with.
"""
