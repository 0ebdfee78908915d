"""The tool: what tells this very installation from another one, or from itself after an upgrade or an edit.

Its own files are many, and are told by their signatures (device, inode, size, times) as git does it: one that was
changed within two seconds of the record may change again without another signature, and on a disk that keeps whole
seconds any may; of those the content counts. Of all other packages the names in the folders that Python imports from
are enough: an upgrade changes the name of the folder of its metadata. Of the names those count that can be imported, or
are metadata: one of these folders may be the one that somebody stands in (``python -m``) or where a script is, where
files come and go. A folder without ``__init__.py`` does not count either: Python takes it where nothing else has the
name. When it is looked at is no part of the answer: a file that was young then, and is not now, has two answers, and a
run too many is made.
"""

from __future__ import annotations

import os
import sys

from ..cache import digest
from .disk import FILE, FOLDER, disk

RACY = 2_000_000_000  # ns
_SECOND = 1_000_000_000
_END = "\0"
_WAYS = ("__editable__", ".pth", ".egg-link")  # files that lead Python to packages elsewhere
_METADATA = (".dist-info", ".egg-info", ".egg")
_COUNTS = (".py", ".pyc", ".so", ".pyd", *_WAYS[1:], *_METADATA)


def is_racy(changed: int, since: int) -> bool:
    """Say whether a file may have changed without another signature: ``since`` is when it was looked at, in ns."""
    return changed > since - RACY or changed % _SECOND == 0


def signature(folders: str, since: int) -> str:
    """Return what tells the tool from another one; ``folders`` are those of its files, ``since`` as ``is_racy``."""
    told = [sys.version, sys.executable]
    for folder in sys.path:
        told += [folder, *_listed(folder, since)]
    for folder in folders.split(_END):
        told += _signed(folder, since)
    return digest(_END.join(told).encode("utf-8", "surrogateescape"))


def _listed(folder: str, since: int) -> list[str]:
    """Return the names in a folder that can be imported or are metadata, and what leads to packages elsewhere."""
    try:
        names = disk().names(folder or ".")
    except NotADirectoryError:  # an archive
        return [_one(folder, since)]
    except OSError:
        return []
    told = []
    for name, kind in names.items():
        path = os.path.join(folder, name)
        if name.startswith(_WAYS[0]) or name.endswith(_WAYS[1:]):
            told.append(_one(path, since))
        if name.endswith(_COUNTS) or (kind == FOLDER and _is_package(path)):
            told.append(name)
    return told


def _is_package(folder: str) -> bool:
    try:
        return disk().status(os.path.join(folder, "__init__.py")).kind == FILE
    except OSError:
        return False


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
