"""Cut recordings: bags whose end is missing, because the recorder was killed or the copy broke off.

rosbags opens a bag by what stands at its end: the index of an .mcap, the last pages of a .db3. Here they are read from
their begin, one record after the other, until there is no more. The readers have what is used of those of rosbags.
"""

from __future__ import annotations

import sqlite3
from collections import deque
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import NamedTuple, Protocol

from .cut_mcap import MAGIC, CutMcap, NoMcap

FAR = 2**63 - 1  # ns
ROWS_OF_A_PAGE = 64


class Definition(NamedTuple):
    """The text of a message definition."""

    data: str


class Connection(NamedTuple):
    """A topic of a recording."""

    id: int
    topic: str
    msgtype: str
    msgdef: Definition


class CutReader(Protocol):
    """A reader of a recording whose end is missing; times in ns."""

    connections: list[Connection]
    message_count: int
    start_time: int
    end_time: int

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield topic, time of arrival and bytes of what can be read."""

    def close(self) -> None:
        """Close the file."""


def is_cut(path: Path) -> bool:
    """Say whether the end of a bag file is missing: an .mcap ends as it begins, a .db3 says how many pages it has."""
    try:
        with path.open("rb") as file:
            head = file.read(100)
            size = file.seek(0, 2)
            if head.startswith(MAGIC):
                file.seek(max(0, size - len(MAGIC)))
                return size < 2 * len(MAGIC) or file.read() != MAGIC
    except OSError:
        return False
    page = int.from_bytes(head[16:18], "big")
    pages = int.from_bytes(head[28:32], "big")
    return head.startswith(b"SQLite format 3\0") and size < (65536 if page == 1 else page) * pages


def opened(path: Path) -> CutReader | None:
    """Return a reader of what is left of a file; None if that is not even its begin."""
    try:
        return _Mcap(path) if path.suffix == ".mcap" else _Sqlite(path)
    except (NoMcap, sqlite3.Error, OSError):
        return None


class _Mcap:
    """An .mcap without its end."""

    def __init__(self, path: Path) -> None:
        self.file = CutMcap(path)
        self.message_count, self.start_time, self.end_time = 0, FAR, 0
        for _, time, _ in self.file.messages():
            self.message_count += 1
            self.start_time, self.end_time = min(self.start_time, time), max(self.end_time, time)
        self.connections = [
            Connection(key, channel.topic, channel.type, Definition(channel.definition))
            for key, channel in self.file.channels.items()
        ]

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        wanted = {connection.id: connection for connection in connections}
        first, behind = start or 0, FAR if stop is None else stop
        for key, time, data in self.file.messages():
            if key in wanted and first <= time < behind:
                yield wanted[key], time, data

    def close(self) -> None:
        self.file.close()


class _Sqlite:
    """A .db3 without its end: what the pages that are left hold, in the order in which it was written."""

    def __init__(self, path: Path) -> None:
        self.database = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True)
        # Without this sqlite refuses a file that is shorter than its header says.
        self.database.execute("PRAGMA writable_schema=ON")
        topics = self.database.execute("SELECT id, name, type FROM topics ORDER BY id").fetchall()
        self.connections = [Connection(key, name, kind, Definition("")) for key, name, kind in topics]
        self.message_count, self.start_time, self.end_time = 0, FAR, 0
        for _, time, _ in self.messages(self.connections):
            self.message_count += 1
            self.start_time, self.end_time = min(self.start_time, time), max(self.end_time, time)

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        wanted = {connection.id: connection for connection in connections}
        first, behind = start or 0, FAR if stop is None else stop
        for key, time, data in self._rows():
            if key in wanted and isinstance(time, int) and isinstance(data, bytes) and first <= time < behind:
                yield wanted[key], time, data

    def _rows(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield the rows before the missing pages; the last may hold zeros, which sqlite puts where it lacks bytes."""
        rows = self.database.execute("SELECT topic_id, timestamp, data FROM messages NOT INDEXED ORDER BY id")
        waiting: deque[tuple[int, int, bytes]] = deque()
        while True:
            try:
                row = rows.fetchone()
            except sqlite3.Error:  # here they begin
                return
            if row is None:
                return
            waiting.append(row)
            if len(waiting) > ROWS_OF_A_PAGE:
                yield waiting.popleft()

    def close(self) -> None:
        self.database.close()
