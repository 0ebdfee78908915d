"""The user's cache folder, for the names of written artifacts.

It follows the XDG base directory specification; ``ROSORIN_COMPILE_CACHE`` names another folder, or disables it if it
is ``off``. Everything works without it.
"""

from __future__ import annotations

import os
from pathlib import Path

from . import system


def top_folder() -> Path | None:
    """Return the absolute folder of the cache, or None if it is disabled or this system has no owners of files."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen == "off" or not system.HAS_OWNERS:
        return None
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not base.is_absolute():  # an empty HOME would be the root of the disk
        base = Path("~/.cache").expanduser() if os.environ.get("HOME", "~") else Path()
    top = Path(os.path.abspath(chosen)) if chosen else base / "rosorin-compile"
    return top if top.is_absolute() else None
