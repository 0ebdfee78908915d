"""Remember the names of artifacts that this user has written: those without a mark are recognized by them.

The names are in the user's cache folder (XDG base directory specification), or in that of ``ROSORIN_COMPILE_CACHE``;
``off`` turns it off. Without them, a file without a mark is recognized by the marks of its neighbours.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from rosorin_compile.source import system
from rosorin_compile.source.cache import top_folder
from rosorin_compile.source.load import json_of


def remember(path: Path, files: Collection[str] = (), complete: bool = True) -> None:
    """Store the names of the artifacts in a folder, or that the file ``path`` is an artifact.

    Without ``complete``, ``files`` are added to the names that are stored, if there are any. A failure is silent.
    """
    record, known = _record(path), remembered(path)
    names = set(files) if complete else set(files) | (known or set())
    if record is None or known == names or not (complete or known is not None):
        return
    with suppress(OSError):
        record.parent.mkdir(0o700, parents=True, exist_ok=True)
        new = record.with_name(f".{os.urandom(8).hex()}")
        new.write_text(json.dumps(sorted(names)), "utf-8")
        new.replace(record)


def remembered(path: Path) -> set[str] | None:
    """Return the names that ``remember`` stored, or None; also if others may have changed them."""
    record = _record(path)
    try:
        if record is None or not all(_is_private(place) for place in (record.parent, record)):
            return None
        names = json_of(record.read_bytes())
    except (OSError, ValueError):
        return None
    return {str(name) for name in names} if isinstance(names, list) else None


def _is_private(path: Path) -> bool:
    status = path.lstat()
    return system.is_own(status) and not status.st_mode & 0o022


def _record(path: Path) -> Path | None:
    """Return the file with the names of a folder, or None if there is no cache."""
    top = top_folder()
    name = blake2b(os.fsencode(os.path.abspath(path)), digest_size=32).hexdigest()
    return top / "outputs" / f"{name}.json" if top is not None else None
