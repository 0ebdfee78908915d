"""Paths as people read them."""

from __future__ import annotations

import os
from pathlib import Path


def nearest_file(path: Path) -> Path | None:
    """Return the file of the same folder that is called nearly so, whatever its ending; None if none is."""
    from .diagnostic import nearest

    try:
        # Files of one kind end alike: that is no likeness.
        stems = {file.stem: file for file in sorted(path.parent.iterdir()) if file.is_file()}
    except (OSError, ValueError):  # no folder, or a name that no file can have
        return None
    close = nearest(path.stem, stems)
    return None if close is None else stems[close]


def shown(path: Path) -> str:
    """Return a path as a person would name it: relative to here if it is below."""
    try:
        here = os.path.relpath(path)
    except OSError:  # the folder of this process is gone
        return str(path)
    return str(path) if here.startswith("..") else here
