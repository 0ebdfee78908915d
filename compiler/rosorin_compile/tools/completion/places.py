"""Files and folders as a shell completes them: of the folder that is typed, those whose names begin as typed."""

from __future__ import annotations

import os
from collections.abc import Sequence

MAX_FILES = 2000


def files(current: str, endings: Sequence[str] | None = None) -> list[str]:
    """Return files (those of ``endings``; None: all) and folders, which end in ``/``, as one would go on typing.

    ``~`` is the home folder, and stays as it is typed. Hidden files show when their dot is typed; a name that begins
    with a dash needs ``./`` to be none of the options.
    """
    if current == "~":
        return ["~/"]
    before, slash, start = current.rpartition("/")
    folder = os.path.expanduser(before + slash) or "."
    found = []
    try:
        with os.scandir(folder) as entries:
            for entry in entries:
                name = entry.name
                if not name.startswith(start or tuple(set(name[:1]) - set("."))) or not name.isprintable():
                    continue
                if name.startswith("-") and not slash:
                    continue
                if entry.is_dir():
                    found.append(f"{before}{slash}{name}/")
                elif endings is None or name.lower().endswith(tuple(endings)):
                    found.append(f"{before}{slash}{name}")
                if len(found) > MAX_FILES:
                    break
    except (OSError, ValueError):  # no folder, or a name that none can have
        return []
    return sorted(found)
