"""The tool: what tells this very installation from another one, or from itself after an upgrade or an edit.

Its own files are many, and are told by their signatures (device, inode, size, times) as git does it: one that was
changed within two seconds of the record may change again without another signature, and on a disk that keeps whole
seconds any may; of those the content counts. Of all other packages the names in the folders that Python imports from
are enough: an upgrade changes the name of the folder of its metadata. When it is looked at is no part of the answer: a
file that was young then, and is not now, has two answers, and a run too many is made.
"""

from __future__ import annotations

import os
import sys

from ..startup.cache import digest
from .disk import FILE, FOLDER, disk

RACY = 2_000_000_000  # ns
_SECOND = 1_000_000_000
_END = "\0"
_WAYS = ("__editable__", ".pth", ".egg-link")  # files that lead Python to packages elsewhere


def is_racy(changed: int, since: int) -> bool:
    """Say whether a file may have changed without another signature: ``since`` is when it was looked at, in ns."""
    return changed > since - RACY or changed % _SECOND == 0


def signature(folders: str, since: int) -> str:
    """Return what tells the tool from another one; ``folders`` are those of its files, ``since`` as ``is_racy``."""
    told = [sys.version, sys.executable, *sys.path]
    for folder in sys.path:
        told += _listed(folder, since)
    for folder in folders.split(_END):
        told += _signed(folder, since)
    return digest(_END.join(told).encode("utf-8", "surrogateescape"))


def _listed(folder: str, since: int) -> list[str]:
    try:
        names = disk().names(folder or ".")
    except OSError:
        return []
    ways = [os.path.join(folder, name) for name in names if name.startswith(_WAYS[0]) or name.endswith(_WAYS[1:])]
    return [*names, *(_one(path, since) for path in ways)]


def _signed(folder: str, since: int) -> list[str]:
    """Return the signature of each file below a folder."""
    told, waiting = [], [folder]
    while waiting:
        here = waiting.pop()
        for name, kind in disk().names(here).items():
            path = f"{here}{os.sep}{name}"
            if kind == FOLDER and name != "__pycache__":
                waiting.append(path)
            elif kind == FILE:
                told.append(_one(path, since))
    return told


def _one(path: str, since: int) -> str:
    status = disk().status(path)
    if is_racy(status.changed, since):
        return f"{path} {digest(disk().read(path)[0])}"
    return f"{path} {status.signature}"
