"""Stamps: knowing that nothing changed since the last run, without compiling.

A stamp is a file in the user's cache that says: this tool, called with this key, found packages in these places, read
inputs with these contents, wrote these artifacts and said this. It holds only as long as all of that is true, by
content. Losing a stamp costs nothing but a compilation, so whatever is odd about one means that there is none.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from .. import __version__, plugins
from ..project import Resolved, tool_folders
from ..startup.again import changed, contents, mark
from ..startup.cache import cache_folder, digest, keep, recalled


def _nowhere(asked: Resolved) -> str:
    raise LookupError(f"nobody says where {asked.kind} {asked.name} is")


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
        # An input is what is most likely another one, and soonest looked at.
        if any(digest(Path(name).read_bytes()) != read for name, read in stamp["inputs"].items()):
            return None
        if contents(os.fspath(folder)) != stamp["outputs"] or stamp["tool"] != tool_mark():
            return None
        if any(leads(Resolved(*one)) != one[-1] for one in stamp["resolved"]):
            return None
        messages = stamp["messages"]
        return messages if isinstance(messages, list) else None
    except Exception:  # a stamp that is missing or damaged in whatever way is no stamp
        return None


class Remembered(NamedTuple):
    """The digests of the files that a run has read, and of the artifacts that it has made, by name."""

    inputs: dict[str, str]
    outputs: dict[str, str]


def remember(
    key: Mapping[str, Any],
    inputs: Iterable[Path],
    outputs: Mapping[str, str | bytes],
    messages: list[Any],
    begun: int | None = None,
    resolved: Iterable[Resolved] = (),
) -> Remembered | None:
    """Write the stamp of a run that read ``inputs`` and made ``outputs``, texts or bytes by name; return what it says.

    ``messages`` is what ``recall`` is to return, plain JSON. ``begun`` is the value of ``now`` from before the inputs
    were read: if one of them was changed since, nobody knows which of its contents was compiled, and nothing is
    remembered. ``resolved`` says where names led. A failure to write is silent.
    """
    with suppress(OSError, ValueError):
        path = _path(key)
        written = {
            name: digest(made if isinstance(made, bytes) else made.encode()) for name, made in sorted(outputs.items())
        }
        if path is None:
            return None
        names = sorted({str(Path(name).absolute()) for name in inputs})
        read = {name: digest(Path(name).read_bytes()) for name in names}
        if begun is not None and any(changed(name) >= begun for name in names):
            return None
        stamp = {
            "tool": tool_mark(),
            "inputs": read,
            "outputs": written,
            "messages": messages,
            "resolved": list(resolved),
        }
        keep(path, json.dumps(stamp).encode())
        return Remembered(read, written)
    return None


def _path(key: Mapping[str, Any]) -> Path | None:
    folder = cache_folder("stamps")
    canonical = json.dumps(key, sort_keys=True, separators=(",", ":"))
    return folder and folder / f"{digest(canonical.encode())}.json"


def tool_mark() -> str:
    """Return what tells this very tool from another one: versions, and size and time of its files and its plug-ins'."""
    parts = [f"{__version__} {sys.version}", *map(mark, tool_folders())]
    return digest("\n".join([*parts, *plugins.mark()]).encode("utf-8", "surrogateescape"))
