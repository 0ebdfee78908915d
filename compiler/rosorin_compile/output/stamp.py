"""Stamps: knowing that nothing changed since the last run, without compiling.

A stamp is a file in the user's cache that says: this tool, called with this key, found packages in these places, read
inputs with these contents, wrote these artifacts and said this. It holds only as long as all of that is true, by
content. Losing a stamp costs nothing but a compilation, so whatever is odd about one means that there is none.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from .. import __version__, plugins
from ..project import DATA, Resolved, data_folder
from ..project.cache import cache_folder, keep, recalled

_CLOCK_REALTIME_COARSE = 5  # linux/time.h; Python has no name for it


def _nowhere(asked: Resolved) -> str:
    raise LookupError(f"nobody says where {asked.kind} {asked.name} is")


def now() -> int:
    """Return the time in nanoseconds, by the clock from which the system takes the times of files."""
    if sys.platform == "linux":
        return time.clock_gettime_ns(_CLOCK_REALTIME_COARSE)
    return time.time_ns()


def recall(key: Mapping[str, Any], folder: Path, leads: Callable[[Resolved], str] = _nowhere) -> list[Any] | None:
    """Return the messages that were remembered under ``key`` if a run would only do the same again, else None.

    That is so if the tool, all inputs and all artifacts in ``folder`` are as they were, no other file is in
    ``folder``, and the names of packages lead where they led: ``leads`` says where one leads now. Never raises.
    """
    try:
        path = _path(key)
        if path is None:
            return None
        stamp = json.loads(recalled(path) or b"")
        if stamp["tool"] != tool_mark() or not _same_outputs(stamp["outputs"], folder):
            return None
        if any(_digest(Path(name).read_bytes()) != digest for name, digest in stamp["inputs"].items()):
            return None
        if any(leads(Resolved(*one)) != one[-1] for one in stamp["resolved"]):
            return None
        messages = stamp["messages"]
        return messages if isinstance(messages, list) else None
    except Exception:  # a stamp that is missing or damaged in whatever way is no stamp
        return None


def remember(
    key: Mapping[str, Any],
    inputs: Iterable[Path],
    outputs: Mapping[str, str | bytes],
    folder: Path,
    messages: list[Any],
    begun: int | None = None,
    resolved: Iterable[Resolved] = (),
) -> None:
    """Write the stamp of a run that read ``inputs`` and made ``outputs``, texts or bytes by name, in ``folder``.

    ``messages`` is what ``recall`` is to return, plain JSON. ``begun`` is the value of ``now`` from before the inputs
    were read: if one of them was changed since, nobody knows which of its contents was compiled, and nothing is
    remembered. ``resolved`` says where names led. A failure to write is silent.
    """
    with suppress(OSError, ValueError):
        path = _path(key)
        written = {
            name: _digest(made if isinstance(made, bytes) else made.encode()) for name, made in sorted(outputs.items())
        }
        if path is None or not _same_outputs(written, folder):
            return
        names = sorted({str(Path(name).absolute()) for name in inputs})
        read = {name: _digest(Path(name).read_bytes()) for name in names}
        if begun is not None and any(_changed(name) >= begun for name in names):
            return
        stamp = {
            "tool": tool_mark(),
            "inputs": read,
            "outputs": written,
            "messages": messages,
            "resolved": list(resolved),
        }
        keep(path, json.dumps(stamp).encode())


def _path(key: Mapping[str, Any]) -> Path | None:
    folder = cache_folder("stamps")
    canonical = json.dumps(key, sort_keys=True, separators=(",", ":"))
    return folder and folder / f"{_digest(canonical.encode())}.json"


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def tool_mark() -> str:
    """Return what tells this very tool from another one: versions, and size and time of its files and its plug-ins'."""
    parts = [f"{__version__} {sys.version}"]
    for folder in (Path(__file__).parent.parent, *map(data_folder, DATA)):
        parts += sorted(_marks(folder))
    parts += plugins.mark()
    return _digest("\n".join(parts).encode("utf-8", "surrogateescape"))


def _marks(folder: Path) -> list[str]:
    """Return the name, size and time of each file below a folder of the tool; this is most of what ``recall`` does."""
    marks = []
    folders = [(os.fspath(folder), "")]
    while folders:
        path, prefix = folders.pop()
        with os.scandir(path) as entries:
            for entry in entries:
                if not entry.is_dir():
                    status = entry.stat()
                    marks.append(f"{prefix}{entry.name} {status.st_size} {status.st_mtime_ns}")
                elif entry.name != "__pycache__":
                    folders.append((entry.path, f"{prefix}{entry.name}/"))
    return marks


def _same_outputs(outputs: Mapping[str, str], folder: Path) -> bool:
    """Say whether ``folder`` holds just these files, digest by relative name. Raises OSError."""
    there = dict(_files(os.fspath(folder), ""))
    return there.keys() == outputs.keys() and all(
        regular and _digest((folder / name).read_bytes()) == outputs[name] for name, regular in there.items()
    )


def _files(folder: str, prefix: str) -> Iterator[tuple[str, bool]]:
    """Yield the relative name of each file below a folder and whether it is a regular one, links not followed."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _files(entry.path, f"{prefix}{entry.name}/")
            else:
                yield prefix + entry.name, entry.is_file(follow_symlinks=False)


def _changed(name: str) -> int:
    status = Path(name).stat()
    return max(status.st_mtime_ns, status.st_ctime_ns)
