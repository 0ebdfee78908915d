"""Places of the schema that hold a name, and the robots that are made for each: see ``judges/names/README.md``."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from support import schemas
from support.paths import ROOT

FOLDER = ROOT / "tests/judges/names"
KEY = "KEY"  # in a path: a key of a mapping; ANY is any key, EACH an entry of a list
ANY, EACH = "*", "[]"
_SCHEMA = schemas.schema("description")
_AUTHORING = schemas.schema("authoring")
# Definitions without any name: texts about a source, files, elements of XML, digests.
_NO_NAMES = ("source", "file", "texture", "element")
_ONCE = ("drive",)  # a robot has one: it is put into the use that is mirrored
_IN_PARTS = frozenset(_AUTHORING["definitions"]["part"]["properties"])
_GIVEN = yaml.safe_load((FOLDER / "robot.yaml").read_text("utf-8"))

_WORD = re.compile(r"\w+")

Steps = tuple[str, ...]
Concrete = tuple[str | int, ...]


class Place(NamedTuple):
    """A place of the language: its path, the kind of thing, whether it gives the name, and a fragment that has it."""

    path: str
    kind: str
    gives: bool
    fragment: dict[str, Any]

    @property
    def name(self) -> str:
        """The name that stands there."""
        return next(found for _, found in reached(self.fragment, steps(self.path)))

    @property
    def is_key(self) -> bool:
        """Whether the name is a key."""
        return self.path.endswith(KEY)


def places() -> list[Place]:
    """Return the places that are listed."""
    listed = yaml.safe_load((FOLDER / "places.yaml").read_text("utf-8"))
    return [Place(path, one.get("names") or one["gives"], "gives" in one, one["in"]) for path, one in listed.items()]


class NoNames(NamedTuple):
    """Paths of texts that are no names, whole, or as they end (``ends``)."""

    whole: tuple[str, ...]
    ends: tuple[str, ...]

    def hold(self, path: str) -> bool:
        """Say whether a path is among them."""
        return path in self.whole or f".{path}".endswith(self.ends)

    def idle(self, paths: list[str]) -> list[str]:
        """Return those that are none of some paths."""
        ends = [end for end in self.ends if not any(f".{path}".endswith(end) for path in paths)]
        return [path for path in self.whole if path not in paths] + ends


def no_names() -> NoNames:
    """Return the texts of the schema that are listed as no names."""
    lines = (FOLDER / "no_names.txt").read_text("utf-8").splitlines()
    listed = [line for line in lines if line and not line.startswith("#")]
    ends = tuple(f".{line.removeprefix('...')}" for line in listed if line.startswith("..."))
    return NoNames(tuple(line for line in listed if not line.startswith("...")), ends)


def things(kind: str) -> tuple[str, ...]:
    """Return the names of the things of one kind that ``robot.yaml`` has, or the program."""
    return tuple(_GIVEN["things"][kind].split())


def in_parts(path: str) -> bool:
    """Say whether a part may hold a place."""
    return steps(path)[0] in _IN_PARTS


def steps(path: str) -> Steps:
    """Return the steps of a path, such as ``("edges", "[]", "parent")``."""
    return tuple(path.replace(EACH, f".{EACH}").split("."))


def texts() -> Iterator[str]:
    """Yield the path of each text of the schema that may be a name: a value, or the key of an open mapping."""
    yield from dict.fromkeys(".".join(path).replace(f".{EACH}", EACH) for path in _texts(_SCHEMA, (), ()))


def _texts(node: Mapping[str, Any], path: Steps, within: tuple[str, ...]) -> Iterator[Steps]:
    defined = node.get("$ref", "").rpartition("/")[2]
    if defined in _NO_NAMES or defined in within:
        return
    if defined:
        node, within = {**_SCHEMA["$defs"][defined], **node, "$ref": ""}, (*within, defined)
    if node.get("type") != "string" and (node.get("additionalProperties") or "propertyNames" in node):
        yield (*path, KEY)
    steps = {schemas.WAY: (), schemas.OTHER: (ANY,), schemas.ITEM: (EACH,)}
    for one in schemas.inner(node):
        yield from _texts(one.fragment, (*path, *steps.get(one.kind, (one.name,))), within)
    if "string" in (kinds if isinstance(kinds := node.get("type"), list) else [kinds]) and "enum" not in node:
        yield path


def unsided(path: str) -> str:
    """Return a path under which a place is found after a mirror at the plane across y, too."""
    return re.sub(r"(?<=[._])(left|right)\b", ANY, path) if path.startswith("drive.") else path


def reached(value: Any, path: Steps, at: Concrete = ()) -> Iterator[tuple[Concrete, Any]]:
    """Yield where a path leads in plain values, and what stands there; of a key the key."""
    if not path:
        if isinstance(value, str):
            yield at, value
        return
    step, rest = path[0], path[1:]
    if step == EACH and isinstance(value, list):
        for index, item in enumerate(value):
            yield from reached(item, rest, (*at, index))
    elif isinstance(value, dict):
        for key, item in value.items():
            if step == KEY and not rest:
                yield (*at, key), key
            elif fnmatchcase(key, step):
                yield from reached(item, rest, (*at, key))


def laid_over(base: Any, over: Any) -> Any:
    """Return a value with another one laid over it: mappings key by key, null takes a key out, all else replaces."""
    if not isinstance(over, dict):
        return over
    made = dict(base) if isinstance(base, dict) else {}
    for key, value in over.items():
        if value is None:
            made.pop(key, None)
        else:
            made[key] = laid_over(made.get(key), value)
    return made


def plain(fragment: dict[str, Any]) -> dict[str, Any]:
    """Return the robot with a fragment laid over it, all in one description without parts."""
    whole = laid_over(_GIVEN["around"], with_words(_GIVEN["part"], {"mount": "pedestal"}))
    return laid_over({"robot": "judge", **whole}, fragment)


def twice(fragment: dict[str, Any]) -> dict[str, Any]:
    """Return the robot with a fragment laid over its part, as far as a part may hold it, which is used twice."""
    inside = {key: value for key, value in fragment.items() if key in _IN_PARTS}
    once = {key: inside.pop(key) for key in _ONCE if key in inside}
    around = {key: value for key, value in fragment.items() if key not in _IN_PARTS}
    uses: dict[str, Any] = {
        "one": {"part": "arm", "prefix": "left_", "parent": "pedestal"},
        "other": {"part": "arm", "prefix": "right_", "parent": "pedestal", "mirror": "y", "content": once},
    }
    robot = {"robot": "judge", **laid_over(_GIVEN["around"], around)}
    return {**robot, "parts": {"arm": laid_over(_GIVEN["part"], inside)}, "use": uses}


def with_words(value: Any, words: dict[str, str]) -> Any:
    """Return plain values in which some words are others, in each text and key."""
    if isinstance(value, dict):
        return {with_words(key, words): with_words(item, words) for key, item in value.items()}
    if isinstance(value, list):
        return [with_words(item, words) for item in value]
    return _WORD.sub(lambda found: words.get(found[0], found[0]), value) if isinstance(value, str) else value


def with_name(value: Any, at: Concrete, is_key: bool, name: str) -> Any:
    """Return plain values with another name at one place."""
    first, rest = at[0], at[1:]
    if isinstance(value, list):
        return [
            with_name(v, rest, is_key, name) if rest and i == first else name if i == first else v
            for i, v in enumerate(value)
        ]
    if rest:
        return {key: with_name(item, rest, is_key, name) if key == first else item for key, item in value.items()}
    return {
        (name if key == first and is_key else key): name if key == first and not is_key else item
        for key, item in value.items()
    }


def swapped(name: str) -> str:
    """Return a name with two letters swapped in its middle."""
    for first in range(1, len(name) - 1):
        if name[first] != name[first + 1]:
            return name[:first] + name[first + 1] + name[first] + name[first + 2 :]
    raise AssertionError(name)


def dumped(folder: Path, description: dict[str, Any]) -> Path:
    """Write a description; return its file."""
    path = folder / "robot.yaml"
    path.write_text(yaml.dump(description, Dumper=yaml.CSafeDumper, sort_keys=False), "utf-8")
    return path


def marked(text: str, at: Concrete, is_key: bool) -> tuple[int, int]:
    """Return line and column, from one, of a value of a YAML text, or of its key, as PyYAML sees it."""
    node: Any = yaml.compose(text)
    for number, step in enumerate(at):
        if isinstance(step, int):
            node = node.value[step]
            continue
        key, inner = next((k, v) for k, v in node.value if k.value == step)
        node = key if is_key and number == len(at) - 1 else inner
    return node.start_mark.line + 1, node.start_mark.column + 1
