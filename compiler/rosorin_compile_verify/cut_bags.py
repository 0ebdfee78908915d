"""Cut recordings: bags whose end is missing, because the recorder was killed or the copy broke off.

rosbags opens a bag by what stands at its end: the index of an .mcap, the last pages of a .db3. Here they are read from
their begin, one record after the other, as far as they are whole (https://mcap.dev/spec). The readers have what is
used of those of rosbags.
"""

from __future__ import annotations

import sqlite3
import struct
from collections import deque
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rosorin_compile.extending import world

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
        with world.stream(path) as file:
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


MAGIC = b"\x89MCAP0\r\n"
_HEADER, _FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 1, 2, 3, 4, 5, 6, 15
_HEAD = struct.Struct("<BQ")  # of every record: what it is, its length
_MESSAGE_HEAD = struct.Struct("<HIQQ")  # channel, sequence, when it was received, when it was published
_CHUNK_HEAD = struct.Struct("<QQQI")  # first and last time, size when it is unpacked, checksum
MAX_RECORD = 1 << 32  # bytes; the length of a longer one is damaged


class NoMcap(Exception):
    """A file does not begin as an .mcap of ROS 2 does."""


class Channel(NamedTuple):
    """A topic, its type, and the definition of that."""

    topic: str
    type: str
    definition: str


class CutMcap:
    """An open .mcap file of which nothing but the begin is needed. Raises NoMcap, OSError."""

    def __init__(self, path: Path) -> None:
        self.channels: dict[int, Channel] = {}
        self._schemas: dict[int, tuple[str, str]] = {}
        self._file = world.stream(path)
        if self._file.read(len(MAGIC)) != MAGIC:
            self.close()
            raise NoMcap("it does not begin as an .mcap")

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def messages(self) -> Iterator[tuple[int, int, bytes]]:
        """Yield channel, time of arrival (ns) and bytes of each message, from the begin to where the file ends."""
        end = self._file.seek(0, 2)
        self._file.seek(len(MAGIC))
        while True:
            head = self._file.read(_HEAD.size)
            if len(head) < _HEAD.size:
                return
            kind, length = _HEAD.unpack(head)
            if kind in (_DATA_END, _FOOTER) or length > MAX_RECORD:
                return
            body = self._file.read(min(length, end - self._file.tell()))  # a length may be damaged
            try:
                if kind == _CHUNK:
                    yield from self._chunk(body)
                elif len(body) == length:
                    yield from self._record(kind, body)
            except (struct.error, UnicodeDecodeError, KeyError):
                return  # bytes that are none of an .mcap: what came before was
            if len(body) < length:
                return

    def _chunk(self, body: bytes) -> Iterator[tuple[int, int, bytes]]:
        """Yield the messages of a chunk in the order of their arrival, of one that is cut those that are left."""
        _, _, size, _ = _CHUNK_HEAD.unpack_from(body)
        compression, at = _text(body, _CHUNK_HEAD.size)
        data = _unpacked(compression, body[at + 8 :])[:size]
        messages: list[tuple[int, int, bytes]] = []
        at = 0
        while at + _HEAD.size <= len(data):
            kind, length = _HEAD.unpack_from(data, at)
            at += _HEAD.size
            if at + length > len(data):
                break
            messages += self._record(kind, data[at : at + length])
            at += length
        yield from sorted(messages, key=lambda message: message[1])

    def _record(self, kind: int, body: bytes) -> Iterator[tuple[int, int, bytes]]:
        """Take a record; yield it if it is a message of a channel."""
        if kind == _MESSAGE:
            channel, _, received, _ = _MESSAGE_HEAD.unpack_from(body)
            yield channel, received, body[_MESSAGE_HEAD.size :]
        elif kind == _SCHEMA:
            name, at = _text(body, 2)
            _, at = _text(body, at)
            self._schemas[_short(body, 0)] = (name, _text(body, at)[0])
        elif kind == _CHANNEL:
            schema = self._schemas.get(_short(body, 2), ("", ""))
            self.channels[_short(body, 0)] = Channel(_text(body, 4)[0], *schema)


def _short(body: bytes, at: int) -> int:
    return int.from_bytes(body[at : at + 2], "little")


def _text(body: bytes, at: int) -> tuple[str, int]:
    """Return a text and the place behind it."""
    (length,) = struct.unpack_from("<I", body, at)
    end = at + 4 + length
    return body[at + 4 : end].decode(), end


def _unpacked(compression: str, data: bytes) -> bytes:
    """Return the bytes of a chunk; of one that is cut, or of a compression that nobody knows, what can be had."""
    if not compression:
        return data
    try:
        return bytes(_unpacker(compression).decompress(data))
    except Exception:  # each library has errors of its own
        return b""


def _unpacker(compression: str) -> Any:
    """Return what unpacks a stream, out of the packages that rosbags brings along."""
    if compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor  # type: ignore[import-untyped]

        return LZ4FrameDecompressor()
    if compression != "zstd":
        raise LookupError(compression)
    try:
        from compression import zstd  # type: ignore[import-not-found,unused-ignore]
    except ImportError:
        from backports import zstd
    return zstd.ZstdDecompressor()
