"""A world of values: files, folders, links, times and variables in one table, behind the door in the place of the disk.

``asked`` has what was asked of it, and whether there was something: from that the next change is drawn.
"""

from __future__ import annotations

import errno
import os
import posixpath
import stat
import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, BinaryIO
from unittest import mock

from rosorin_compile.world.disk import ABSENT, FILE, FOLDER, OTHER, Disk, Status

SECOND = 1_000_000_000


@dataclass
class Node:
    kind: str  # FILE, FOLDER, OTHER or "link"
    inode: int
    data: bytes = b""
    mtime: int = 0
    ctime: int = 0


class Values(Disk):
    """``step`` is how fine the times of files are (ns), ``during`` is called once, after so many reads."""

    def __init__(self, step: int) -> None:
        self.nodes: dict[str, Node] = {"/": Node(FOLDER, 1)}
        self.variables: dict[str, str] = {}
        self.clock = 10**18
        self.step = step
        self.folder = "/r"
        self.inodes = 1
        self.asked: list[tuple[str, str, bool]] = []
        self.during: Callable[[], None] | None = None
        self.reads = 0

    # The system, as the door asks it.

    def status(self, path: str) -> Status:
        node = self._found("status", path)
        kind = OTHER if node.kind not in (FILE, FOLDER) else node.kind
        mode = stat.S_IFREG | 0o644 if kind == FILE else stat.S_IFDIR | 0o755
        told = (1, node.inode, len(node.data), node.mtime, node.ctime)
        return Status(kind, len(node.data), mode, True, node.ctime, " ".join(map(str, told)))

    def read(self, path: str, most: int = -1) -> tuple[bytes, Status, Status]:
        node = self._found("read", path)
        if node.kind == FOLDER:
            raise OSError(errno.EISDIR, "is a folder", path)
        if node.kind != FILE:
            raise OSError(errno.EINVAL, "no regular file", path)
        before, data = self.status(path), node.data
        self.reads -= 1
        if self.during is not None and self.reads == 0:
            during, self.during = self.during, None
            during()
        return (data if most < 0 else data[:most]), before, before

    def stream(self, path: str) -> BinaryIO:
        raise NotImplementedError

    def names(self, folder: str) -> dict[str, str]:
        node = self._found("names", folder)
        if node.kind != FOLDER:
            raise NotADirectoryError(errno.ENOTDIR, "no folder", folder)
        place = self.resolved(folder)
        found = {}
        for path in sorted(self.nodes):
            if path != "/" and posixpath.dirname(path) == place:
                try:
                    there = self.nodes[self.resolved(path)].kind
                except (OSError, KeyError):
                    there = ABSENT
                found[posixpath.basename(path)] = there
        return found

    def link(self, path: str) -> str:
        place = posixpath.join(self.resolved(posixpath.dirname(self._whole(path))), posixpath.basename(path))
        node = self.nodes.get(place)
        self.asked.append(("link", self._whole(path), node is not None))
        if node is None:
            raise FileNotFoundError(errno.ENOENT, "absent", path)
        return node.data.decode() if node.kind == "link" else ""

    def real(self, path: str) -> str:
        self.asked.append(("real", self._whole(path), True))
        try:
            return self.resolved(path)
        except OSError:
            return posixpath.normpath(self._whole(path))

    def here(self) -> str:
        return self.folder

    def environment(self) -> dict[str, str]:
        return self.variables

    def package(self, name: str) -> tuple[str, ...]:
        return () if name else (name,)

    def process(self) -> AbstractContextManager[Any]:
        """Have for a while what a process has that has just begun: here no folder to import from."""
        return mock.patch.object(sys, "path", [])

    def now(self) -> int:
        return self.clock

    def _whole(self, path: str) -> str:
        return posixpath.join(self.folder, path)

    def _found(self, how: str, path: str) -> Node:
        whole = self._whole(path)
        try:
            node = self.nodes.get(self.resolved(path))
        except OSError:
            self.asked.append((how, whole, False))
            raise
        self.asked.append((how, whole, node is not None))
        if node is None:
            raise FileNotFoundError(errno.ENOENT, "absent", path)
        return node

    def resolved(self, path: str, links: int = 0) -> str:
        """Return where a path leads; what is not there stays as it is named. Raises OSError."""
        place = "/"
        parts = [part for part in self._whole(path).split("/") if part not in ("", ".")]
        for number, part in enumerate(parts):
            above = self.nodes.get(place)
            if above is not None and above.kind != FOLDER:
                raise NotADirectoryError(errno.ENOTDIR, "no folder", path)
            if part == "..":
                place = posixpath.dirname(place)
                continue
            place = posixpath.join(place, part)
            node = self.nodes.get(place)
            if node is not None and node.kind == "link":
                if links > 20:
                    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), path)
                target = posixpath.join(posixpath.dirname(place), node.data.decode())
                return self.resolved(posixpath.join(target, *parts[number + 1 :]), links + 1)
        return place

    # Changes.

    def tick(self, by: int) -> None:
        self.clock += by

    def write(self, path: str, data: bytes, keep_time: bool = False) -> None:
        """Write a file, links followed; ``keep_time`` as ``rsync -a`` and ``tar`` do."""
        try:
            place = self.resolved(path)
        except OSError:
            return
        before = self.nodes.get(place)
        if self.nodes.get(posixpath.dirname(place), Node("", 0)).kind != FOLDER or (before and before.kind != FILE):
            return
        now = self.clock // self.step * self.step
        self.inodes += 1
        inode = before.inode if before else self.inodes
        self.nodes[place] = Node(FILE, inode, data, before.mtime if before and keep_time else now, now)

    def make(self, path: str, kind: str, target: str = "") -> None:
        """Make a folder, a link or a pipe, where there is nothing."""
        try:
            above = self.resolved(posixpath.dirname(path))
        except OSError:
            return
        place = posixpath.join(above, posixpath.basename(path))
        if place in self.nodes or self.nodes.get(above, Node("", 0)).kind != FOLDER:
            return
        self.inodes += 1
        now = self.clock // self.step * self.step
        self.nodes[place] = Node(kind, self.inodes, target.encode(), now, now)

    def remove(self, path: str) -> None:
        """Remove what stands there, the link itself where it is one, and all below."""
        try:
            above = self.resolved(posixpath.dirname(path))
        except OSError:
            return
        place = posixpath.join(above, posixpath.basename(path))
        for one in [one for one in self.nodes if one == place or one.startswith(place + "/")]:
            del self.nodes[one]

    def move(self, path: str, to: str) -> None:
        """Move what stands there, with all below, to where there is nothing; times stay, but for that of its change."""
        try:
            old, new = (
                posixpath.join(self.resolved(posixpath.dirname(one)), posixpath.basename(one)) for one in (path, to)
            )
        except OSError:
            return
        if (
            old not in self.nodes
            or new in self.nodes
            or self.nodes.get(posixpath.dirname(new), Node("", 0)).kind != FOLDER
        ):
            return
        if new.startswith(old + "/"):
            return
        for one in [one for one in self.nodes if one == old or one.startswith(old + "/")]:
            self.nodes[new + one[len(old) :]] = self.nodes.pop(one)
        self.nodes[new].ctime = self.clock // self.step * self.step

    def folder_of(self, path: str) -> dict[str, bytes]:
        """Return the files below a folder, by relative name."""
        return {one[len(path) + 1 :]: node.data for one, node in self.nodes.items() if one.startswith(path + "/")}
