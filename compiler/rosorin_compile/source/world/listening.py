"""Listening: what code of others opens or lists is noted, too: of plug-ins, of trimesh, of a xacro.

Python tells it (``sys.addaudithook``). What it does not tell is whether somebody merely looked if a file is there:
such code opens what it finds, and what it finds nowhere it does not open. Whatever else goes past the door (another
process, the network) spoils the notes.
"""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from rosorin_compile.source.tool import folders

from ..cache import private_folder
from .asking import environment, names, read
from .notes import Notes, are_open, note_heard, noting

if TYPE_CHECKING:
    from collections.abc import Iterator

_SPOILING = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.spawn", "os.fork", "socket.connect")
_OURS = tuple(os.path.abspath(folder) + os.sep for folder in folders().values())
_PYTHON = os.path.dirname(os.path.abspath(os.__file__)) + os.sep
_SITE = ("site-packages", "dist-packages")
_listening: list[bool] = []
_state = {"hooked": False, "deaf": False}


def listen() -> None:
    """Note what is opened from now on, and the whole environment; nobody knows what of it the code of others takes."""
    if _listening:
        return
    _listening.append(True)
    _quietly(list, environment())
    if not _state["hooked"]:
        _state["hooked"] = True
        sys.addaudithook(_hear)


class listening:  # noqa: N801 - it is used as a function
    """Listen until the end of the block."""

    def __enter__(self) -> None:
        self.before = bool(_listening)
        listen()

    def __exit__(self, *_: object) -> None:
        if not self.before:
            _listening.clear()


def _hear(event: str, given: tuple[object, ...]) -> None:
    if not _listening or _state["deaf"] or not are_open():
        return
    if event == "open":
        _opened(*given[:3])
    elif event in ("os.listdir", "os.scandir"):
        folder = given[0]
        if not isinstance(folder, (str, bytes)) or not _is_of_cache(os.fsdecode(folder)):
            _quietly(_list, folder)
    elif event in _SPOILING:
        notes = Notes()
        notes.spoiled = f"code of others has called {event}"
        note_heard(notes)


def _opened(path: object, mode: object, flags: object) -> None:
    if not isinstance(path, (str, bytes)) or _is_for_writing(mode, flags):
        return
    for name in _files(os.path.abspath(os.fsdecode(path))):
        if not _is_of_python(name) and not _is_of_cache(name):
            _quietly(read, name)


def _files(path: str) -> Iterator[str]:
    """Yield the file that was opened; of a compiled module also its source, whose time Python has looked at."""
    yield path
    if path.endswith(".pyc") and os.path.basename(os.path.dirname(path)) == "__pycache__":
        above = os.path.dirname(os.path.dirname(path))
        yield os.path.join(above, f"{os.path.basename(path).partition('.')[0]}.py")


def _is_for_writing(mode: object, flags: object) -> bool:
    if isinstance(mode, str):
        return bool(set(mode) & set("wxa+"))
    return isinstance(flags, int) and bool(flags & (os.O_WRONLY | os.O_RDWR))


def _is_of_python(path: str) -> bool:
    """Say whether a file is of the tool or of Python itself, which are known as a whole."""
    if path.startswith(_OURS):
        return True
    return path.startswith(_PYTHON) and not path[len(_PYTHON) :].startswith(_SITE)


def _is_of_cache(path: str) -> bool:
    """Say whether a path is in the user's cache: what is found there is known by what it was made of."""
    top = os.path.dirname(private_folder("runs"))
    return bool(top) and (os.path.abspath(path) + os.sep).startswith(top + os.sep)


def _list(folder: object) -> None:
    if folder is None or isinstance(folder, (str, bytes)):
        names(os.fsdecode(folder or "."))


def _quietly(ask: object, subject: object) -> None:
    """Ask the door, which asks the system in its turn: that is not heard."""
    _state["deaf"] = True
    try:
        with noting() as notes:
            ask(subject)  # type: ignore[operator]
    except OSError:  # it is noted that there is none
        pass
    finally:
        _state["deaf"] = False
    note_heard(notes)
