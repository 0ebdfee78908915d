"""Paths as people read them."""

from __future__ import annotations

import os
from pathlib import Path


def shown(path: Path) -> str:
    """Return a path as a person would name it: relative to here if it is below."""
    here = os.path.relpath(path)
    return str(path) if here.startswith("..") else here
