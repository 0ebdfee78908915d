"""MJCF read into the plain tree: MuJoCo reads the file in a child process, and the text is read for the places.

To be read in this order: ``robot`` (the file as a whole), ``process`` and ``engine`` (MuJoCo is asked), ``source`` and
``reading`` (the text, and what is known so far), then ``links``, ``joints``, ``shapes`` and ``sections``, which fill
the tree with the help of ``planting`` and ``numbers``; last ``left_out``, which lists what is not carried.
"""

from __future__ import annotations

from pathlib import Path

from ..imported import Imported
from ..options import ReadOptions

__all__ = ["read_mjcf"]


def read_mjcf(path: Path, options: ReadOptions) -> Imported:
    """Return the robot of an MJCF as a plain tree (see ``robot``)."""
    from .robot import read_mjcf as read  # the child process imports this package too, and needs no reader

    return read(path, options)
