"""Importing: robots that exist as URDF, xacro, MJCF or the JSON of a driver, read into the plain tree.

To be read in this order: ``reader`` (which format a file has), ``imported`` (what comes of it), a folder for each
format (``urdf``, ``xacro``, ``mjcf``; ``robot_model`` is one module), then ``writing`` (the tree as files) and
``round_trip`` (they mean the same). Below all formats: ``files``, ``markup``, ``packages``, ``options``, ``accepting``.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from ..diagnostic import Diagnostic, Span
from ..emit import endings
from .imported import Comment, Imported, LeftOut
from .options import ReadOptions

__all__ = ["Comment", "Imported", "LeftOut", "ReadOptions", "Readers", "read_robot"]

Tell = Callable[[Diagnostic], None]


def read_robot(path: Path, options: ReadOptions | None = None, asked: Span | None = None) -> Imported:
    """Return the robot of a file in any format. Never raises: what is wrong is a diagnostic, and then no tree.

    The name of the file and what stands in it decide on the format. ``asked`` is the place that names the file, if a
    description does.
    """
    from .reader import read

    return read(path, options or ReadOptions(), asked)


class Readers:
    """Reads the foreign robots that descriptions include (``expand.vendor.ForeignReader``)."""

    def endings(self) -> tuple[str, ...]:
        """Return how the names of files end that a description may include and that are no descriptions."""
        return endings(include=True)

    def read(
        self, path: Path, texts: Mapping[str, str], packages: Mapping[str, Path], lenient: bool, tell: Tell, by: Span
    ) -> Imported:
        """Return the robot of a file; ``by`` is the place that names it."""
        return read_robot(path, ReadOptions(texts, packages, lenient, tell=tell), by)

    def package(self, name: str, packages: Mapping[str, Path], by: Path) -> Path | None:
        """Return the folder of a ROS package that a file names; None if it is not found."""
        from .packages import Packages

        return Packages(packages, os.environ, by).find(name)
