"""Verify: recordings of a running robot held against its description.

A recording flows from file to file, in the order to read them:

1. ``sources`` tells what a source is and takes it through the rest.
2. ``expected`` says what the description lets one expect: its edges, and how exactly they are known.
3. ``bags`` reads what rosbag2 recorded, ``text`` what was pasted from a terminal, batch by batch.
4. ``recording`` keeps statistics of fixed size of what streams by.
5. ``judging`` holds them against what is expected; each thing that is wrong is one of the ``findings``.
6. ``verdict`` is what comes out, and ``output`` shows it: as lines, as JSON and JUnit XML, as a picture.

``arrays`` is what all of them calculate with.
"""

from __future__ import annotations

from .expected import Options
from .sources import verify
from .verdict import Verdict

__all__ = ["Options", "Verdict", "verify"]
