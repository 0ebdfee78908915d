"""Metadata: what metadata.yaml says of a rosbag2 folder, held to what the format says before anybody believes it.

(rosbag2_storage/src/rosbag2_storage/yaml.cpp writes it; versions 1 to 9 have the keys that are asked for here.)
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import Source, printable
from rosorin_compile.extending import world

FILE = "metadata.yaml"
MAX_BYTES = 16 << 20
_TOP = "rosbag2_bagfile_information"
_HELP = "ros2 bag reindex FOLDER writes it anew; without it, or by its own name, each file of the folder can be read"
_KINDS = {int: "a whole number", str: "a text", list: "a list", dict: "a mapping"}


class Unreadable(Exception):
    """A recording cannot be read at all; the text says why, ``help`` what to do."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


class Metadata(NamedTuple):
    """The files of a folder in their order, and whether they or their messages are compressed from outside."""

    files: tuple[Path, ...]
    packed: bool


def read_metadata(folder: Path) -> Metadata:
    """Return what metadata.yaml says of a folder. Raises Unreadable with the line of what is wrong in it."""
    path = folder / FILE
    try:
        data = world.head(path, MAX_BYTES + 1)
    except OSError as wrong:
        raise _wrong(path, str(wrong.strerror)) from None
    if len(data) > MAX_BYTES:
        raise _wrong(path, f"it is larger than any ({MAX_BYTES >> 20} MiB)")
    try:
        text = data.decode()
        tree = Source("", text).yaml()
    except UnicodeDecodeError:
        raise _wrong(path, "it is no text in UTF-8") from None
    except ValueError as wrong:
        raise _wrong(path, str(wrong)) from None
    return _Checked(path, text).metadata(tree)


def _wrong(path: Path, why: str) -> Unreadable:
    return Unreadable(f"{path} cannot be read: {why}", _HELP)


class _Checked:
    """Goes through the tree of one metadata.yaml."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text

    def metadata(self, tree: Any) -> Metadata:
        """Return what is needed of it. Raises Unreadable."""
        if not isinstance(tree, dict) or _TOP not in tree:
            raise _wrong(self.path, f"it does not begin with {_TOP}")
        top = self.get(tree, (), _TOP, dict)
        for key in ("version", "message_count"):
            self.number(top, (_TOP,), key)
        self.get(top, (_TOP,), "storage_identifier", str)
        for key, inner in (("duration", "nanoseconds"), ("starting_time", "nanoseconds_since_epoch")):
            self.number(self.get(top, (_TOP,), key, dict), (_TOP, key), inner)
        self.topics(self.get(top, (_TOP,), "topics_with_message_count", list))
        if "files" in top:
            self.get(top, (_TOP,), "files", list)
        packed = False
        for key in ("compression_format", "compression_mode"):
            if top.get(key) is not None:
                packed |= self.get(top, (_TOP,), key, str).lower() not in ("", "none")
        return Metadata(tuple(self.files(top)), packed)

    def topics(self, topics: list[Any]) -> None:
        """Hold the topics to what one has."""
        for at, topic in enumerate(topics):
            way = (_TOP, "topics_with_message_count", at)
            if not isinstance(topic, dict):
                raise self.not_a(way, topic, dict)
            self.number(topic, way, "message_count")
            inner = self.get(topic, way, "topic_metadata", dict)
            for key in ("name", "type", "serialization_format"):
                self.get(inner, (*way, "topic_metadata"), key, str)
            self.profiles(inner, (*way, "topic_metadata"))

    def profiles(self, inner: Mapping[str, Any], way: tuple[Any, ...]) -> None:
        """Hold the QoS profiles of a topic to a list: YAML, or YAML in a text, of which nobody knows how deep it is."""
        key = "offered_qos_profiles"
        profiles = inner.get(key)
        try:
            profiles = Source("", profiles).yaml() if isinstance(profiles, str) else profiles
        except ValueError as wrong:
            raise _wrong(self.path, f"{self.line((*way, key))}{key}: {wrong}") from None
        if profiles is not None and not (
            isinstance(profiles, list) and all(isinstance(profile, dict) for profile in profiles)
        ):
            raise self.not_a((*way, key), inner[key], list)

    def files(self, top: Mapping[str, Any]) -> list[Path]:
        """Return the files that are named; each has to be one, in this folder."""
        way = (_TOP, "relative_file_paths")
        named = self.get(top, (_TOP,), "relative_file_paths", list)
        found = []
        for at, name in enumerate(named):
            if not isinstance(name, str):
                raise self.not_a((*way, at), name, str)
            file = self.path.parent / PurePosixPath(name).name
            if world.kind(file) != world.FILE:
                where = self.line((*way, at))
                raise _wrong(self.path, f"{where}there is no file {printable(name)[:200]} beside it")
            found.append(file)
        return found

    def number(self, of: Mapping[str, Any], way: tuple[Any, ...], key: str) -> int:
        """Return a whole number that is one of messages or of times. Raises Unreadable."""
        value: int = self.get(of, way, key, int)
        # Of an empty recording the first time is the last of all.
        if not -(2**63) <= value < 2**63 or (value < 0 and "since_epoch" not in key):
            raise _wrong(self.path, f"{self.line((*way, key))}{key} cannot be {_shown(value)}")
        return value

    def get(self, of: Mapping[str, Any], way: tuple[Any, ...], key: str, kind: type) -> Any:
        """Return the value of a key, of a kind. Raises Unreadable."""
        if key not in of:
            raise _wrong(self.path, f"{self.line(way)}{way[-1] if way else FILE} has no {key}")
        value = of[key]
        if not isinstance(value, kind) or isinstance(value, bool):
            raise self.not_a((*way, key), value, kind)
        return value

    def not_a(self, way: tuple[Any, ...], value: Any, kind: type) -> Unreadable:
        """Return the error about a value of another kind."""
        name = way[-1] if isinstance(way[-1], str) else f"an entry of {way[-2]}"
        return _wrong(self.path, f"{self.line(way)}{name} is {_shown(value)}, not {_KINDS[kind]}")

    def line(self, way: tuple[Any, ...]) -> str:
        """Return the line of a key or an entry in words; nothing if that cannot be told."""
        import yaml

        node = yaml.compose(self.text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        mark = node.start_mark if node is not None else None
        for key in way:
            if isinstance(node, yaml.SequenceNode) and isinstance(key, int):
                node = node.value[key]
                mark = node.start_mark
            elif isinstance(node, yaml.MappingNode):
                pair = next((pair for pair in node.value if pair[0].value == key), None)
                if pair is None:
                    break
                mark, node = pair[0].start_mark, pair[1]
        return f"line {mark.line + 1}: " if mark is not None else ""


def _shown(value: Any) -> str:
    """Return a value in a few words."""
    if value is None:
        return "empty"
    if isinstance(value, (list, dict)):
        return _KINDS[list if isinstance(value, list) else dict]
    text = printable(str(value).lower() if isinstance(value, bool) else str(value))
    text = text if len(text) <= 40 else f"{text[:37]}..."
    return f'"{text}"' if isinstance(value, str) else text
