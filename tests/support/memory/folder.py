"""The same world as a real folder: what is changed in the values is changed on the disk too, and asked of the disk."""

from __future__ import annotations

import os
import posixpath
import shutil
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, BinaryIO

from rosorin_compile.world.disk import Disk, Status

from . import plugin
from .values import FILE, FOLDER, Node, Values


class Folder(Values):
    """Values that stand below ``top``, where ``/`` of the program is; links are those of the disk."""

    def __init__(self, top: Path) -> None:
        self.top = os.path.realpath(top)
        self.disk = Disk()
        super().__init__(1)

    def _at(self, path: str) -> str:
        if path.startswith(self.top + os.sep):  # as Python names it
            return path
        return self.top + posixpath.join(self.folder, path)

    def _below(self, path: str) -> str:
        return path[len(self.top) :] or "/" if path.startswith(self.top) else path

    def status(self, path: str) -> Status:
        self._note("status", path)
        return self.disk.status(self._at(path))

    def read(self, path: str, most: int = -1) -> tuple[bytes, Status, Status]:
        self._note("read", path)
        data, before, after = self.disk.read(self._at(path), most)
        self.reads -= 1
        if self.during is not None and self.reads == 0:
            during, self.during = self.during, None
            during()
        return data, before, after

    def stream(self, path: str) -> BinaryIO:
        return self.disk.stream(self._at(path))

    def names(self, folder: str) -> dict[str, str]:
        self._note("names", folder)
        return self.disk.names(self._at(folder))

    def link(self, path: str) -> str:
        self._note("link", path)
        return self._below(self.disk.link(self._at(path)))

    def real(self, path: str) -> str:
        self._note("real", path)
        return self._below(self.disk.real(self._at(path)))

    def process(self) -> AbstractContextManager[Any]:
        """Have for a while what a process has that has just begun, with packages in /s."""
        return plugin.process(f"{self.top}/s", self.variables)

    def now(self) -> int:
        return self.disk.now()

    def _note(self, how: str, path: str) -> None:
        whole = posixpath.join(self.folder, self._below(path))
        if not whole.startswith(plugin.STANDARD):
            self.asked.append((how, whole, os.path.lexists(self._at(path))))

    # Changes.

    def tick(self, by: int) -> None:
        """The time of the disk goes on by itself."""

    def write(self, path: str, data: bytes, keep_time: bool = False) -> None:
        file = Path(self._at(path))
        try:
            before = file.stat() if file.is_file() else None
            if file.exists() and before is None:
                return
            file.write_bytes(data)
            if before is not None and keep_time:
                os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))
        except OSError:
            return

    def make(self, path: str, kind: str, target: str = "") -> None:
        place = self._at(path)
        try:
            if os.path.lexists(place):
                return
            if kind == FOLDER:
                Path(place).mkdir()
            elif kind == "link":
                Path(place).symlink_to(self.top + target if target.startswith("/") else target)
            else:
                os.mkfifo(place)
        except OSError:
            return

    def remove(self, path: str) -> None:
        place = Path(self._at(path))
        try:
            if place.is_dir() and not place.is_symlink():
                shutil.rmtree(place)
            else:
                place.unlink()
        except OSError:
            return

    def move(self, path: str, to: str) -> None:
        try:
            if not os.path.lexists(self._at(to)) and not self._at(to).startswith(f"{self._at(path)}/"):
                Path(self._at(path)).rename(self._at(to))
        except OSError:
            return

    def folder_of(self, path: str) -> dict[str, bytes]:
        place = Path(self._at(path))
        if not place.is_dir():
            return {}
        found = {}
        for one in sorted(place.rglob("*")):
            found[one.relative_to(place).as_posix()] = one.read_bytes() if one.is_file() else b""
        return found

    @property
    def nodes(self) -> dict[str, Node]:
        """What stands below the folder, as changes look at it."""
        return _Nodes(self)

    @nodes.setter
    def nodes(self, _: dict[str, Node]) -> None:
        """The folder begins empty."""


class _Nodes(dict[str, Node]):
    def __init__(self, folder: Folder) -> None:
        super().__init__()
        self.folder = folder

    def get(self, path: str, default: Node | None = None) -> Node | None:  # type: ignore[override]
        place = Path(self.folder.top + path)
        if place.is_symlink():
            return Node("link", 0)
        if place.is_file():
            return Node(FILE, 0, place.read_bytes())
        return Node(FOLDER, 0) if place.is_dir() else default
