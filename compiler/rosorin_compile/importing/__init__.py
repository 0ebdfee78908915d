"""Importing: robots that exist as URDF, xacro, MJCF or the JSON of a driver, read into the plain tree.

To be read in this order: ``reader`` (which format a file has), ``imported`` (what comes of it), a folder for each
format (``urdf``, ``xacro``, ``mjcf``; ``robot_model`` is one module), then ``writing`` (the tree as files) and
``round_trip`` (they mean the same). Below all formats: ``files``, ``markup``, ``packages``, ``options``, ``accepting``.
"""

from __future__ import annotations

from pathlib import Path

from ..diagnostic import Span
from .imported import Comment, Imported, LeftOut
from .options import ReadOptions

__all__ = ["Comment", "Imported", "LeftOut", "ReadOptions", "read_robot"]


def read_robot(path: Path, options: ReadOptions | None = None, asked: Span | None = None) -> Imported:
    """Return the robot of a file in any format. Never raises: what is wrong is a diagnostic, and then no tree.

    The name of the file and what stands in it decide on the format. ``asked`` is the place that names the file, if a
    description does.
    """
    from .reader import read

    return read(path, options or ReadOptions(), asked)
