"""The user's cache folder, for what may be thrown away at any time."""

from __future__ import annotations

import os
from pathlib import Path


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of cached files, made private to the user; None if there is nowhere to write.

    ``ROSORIN_COMPILE_CACHE`` names another place; ``off`` turns caching off. Otherwise the XDG base directory
    specification holds.
    """
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen == "off":
        return None
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = Path(chosen or os.path.join(base, "rosorin-compile")) / name
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    except OSError:
        return None
    return folder if os.access(folder, os.W_OK) else None
