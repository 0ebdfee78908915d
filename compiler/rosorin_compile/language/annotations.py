"""Annotations: what the schema of descriptions says of a value beside its form, for whoever walks a description.

| annotation | where | meaning |
|---|---|---|
| ``x-names`` | a text, ``propertyNames`` | the text, or each key, is the name of something of this kind |
| ``x-gives`` | the same | something of this kind gets its name there |
| ``x-otherwise`` | beside ``x-gives`` | the name where the key is left out: ``{frame}_joint`` |
| ``x-spelt`` | a text, ``propertyNames`` | its words are held against usual ones; what it is called: ``plugin`` |
| ``x-said`` | beside ``x-names`` | what is said of a name of nothing; ``{1}``: the second step of the path to it |
| | | false: a rule of its own tells that, or none, here and below |
| ``x-among`` | beside ``x-names`` | where it is looked up: in a ``simulation``, in the ``description``; |
| | | left out: a link or a joint in the description, another kind by a rule of its own |
| ``x-scope`` | beside them | ``robot``: never with the prefix of a part; ``world``: it gives no name of the part |
| ``x-names-in`` | any value | names stand inside of it; the function that knows where |
| ``x-mirror`` | a mapping | how a mirror turns what it holds |
| ``x-unmirrored`` | a mapping | why a mirror leaves its poses and directions as they are |
| ``x-attached`` | a text | where it names the mount, these keys beside it are composed with the pose of the use: |
| | | ``xyz`` and ``rpy``, and others are directions |
| ``x-in-parts`` | a section | it may stand in a part |
| ``x-in-types`` | a key of a sensor | a type of sensors may say it for its sensors |
| ``x-accepted`` | a mapping | what is wrong with it may be accepted (``accept``) of these names: ``{1}``, ``{child}`` |
| ``x-whole`` | a section | said of the robot as a whole: one that is included brings none |
| ``x-called`` | a section | what one of its entries is called |
| ``x-reckoned`` | any value | its numbers are calculated with: none may be beyond reckoning; false: not below |
| ``x-explained`` | a section | its entries have no frame; ``explain`` shows where their numbers were written: |
| | | true: of each entry; a word: behind this word with each joint that they name |
| ``x-topic`` | a section | a format that ``lacks`` this topic has no word for it |
| ``x-compared`` | a section | its entries are compared value by value, each called so: ``battery main`` |
| ``x-also`` | a key | what others call it (``synonyms``) |
| ``x-instead`` | a definition | the way out for words that are no keys of it, by these words (``synonyms``); |
| | | a text: as the definition that is called so |
| ``x-merge`` | a section | files and parts are joined by its ``entries``, its ``items``, or ``within`` its one entry |
| ``x-sourced`` | a section | its entries have the source of their file, where they have none of their own |
| ``x-within`` | a number | it is within another number of its joint: ``limit`` |
| ``x-ordered`` | a section | its entries are in the model as they are written; else by name |
| ``x-file`` | a section | the file, without its ending, that an import writes it into beside ``robot.yaml`` |
| ``x-first`` | a mapping | the keys that an import writes first; the others stay as in the source |
| | | without it all stand in the order of ``properties`` |
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from typing import Any, Literal, NamedTuple

from .schema import schema

# What else has a name where one of a kind is asked for: a frame is a site of the MJCF too, an actuator is called as its
# joint and a camera as its sensor where they have no name of their own, and shapes are LINK_collision_1.
ALSO: Mapping[str, tuple[str, ...]] = {
    "site": ("link",),
    "actuator": ("joint",),
    "camera": ("sensor",),
    "shape": ("link",),
    "sensor": ("hardware sensor",),
    "link or joint": ("link", "joint"),
}
MIRROR, GIVES, INSIDE, SPELT = "x-mirror", "x-gives", "x-names-in", "x-spelt"
ROBOT, WORLD = "robot", "world"
SIMULATION, DESCRIPTION = "simulation", "description"
ENTRIES, ITEMS, WITHIN = "entries", "items", "within"

# Each annotation and the field of a node that has it.
WORDS = {
    "x-names": "names",
    "x-gives": "gives",
    "x-otherwise": "otherwise",
    "x-scope": "scope",
    "x-spelt": "spelt",
    "x-said": "said",
    "x-among": "among",
    "x-names-in": "inside",
    "x-mirror": "mirror",
    "x-attached": "attached",
    "x-in-parts": "in_parts",
    "x-in-types": "in_types",
    "x-accepted": "accepted",
    "x-reckoned": "reckoned",
    "x-whole": "whole",
    "x-called": "called",
    "x-explained": "explained",
    "x-topic": "topic",
    "x-compared": "compared",
    "x-merge": "merge",
    "x-sourced": "sourced",
    "x-within": "within",
}

# Beside them what ``synonyms``, lowering and an import read: all that validators and editors have no use for.
ANNOTATIONS = frozenset((*WORDS, "x-unmirrored", "x-also", "x-instead", "x-file", "x-first", "x-ordered"))


class Node(NamedTuple):
    """What the schema says of the values at a place.

    ``of`` is what is found here or anywhere below: the kinds of names that are looked up, and MIRROR, GIVES, INSIDE,
    SPELT.
    """

    names: str = ""
    gives: str = ""
    otherwise: str = ""
    scope: str = ""
    spelt: str = ""
    said: str | Literal[False] = ""
    among: str = ""
    inside: str = ""
    mirror: Sequence[str] = ()
    attached: Sequence[str] = ()
    in_parts: bool = False
    in_types: bool = False
    accepted: Sequence[str] = ()
    reckoned: bool | None = None
    whole: bool = False
    called: str = ""
    explained: bool | str = False
    topic: str = ""
    compared: str = ""
    merge: str = ""
    sourced: bool = False
    within: str = ""
    keys: Node | None = None
    properties: Mapping[str, Node | None] = {}
    others: Node | None = None
    items: Node | None = None
    of: frozenset[str] = frozenset()

    def at(self, key: str) -> Node | None:
        """Return what the schema says of the value of a key of a mapping; ``None`` if it says nothing."""
        return self.properties.get(key, self.others)

    def below(self, step: str | int) -> Node | None:
        """Return what the schema says of what is at a step of a path: a key of a mapping, an index of a list."""
        return self.items if isinstance(step, int) else self.at(step)

    def left_out(self, entry: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
        """Yield the keys that are left out and whose name follows from others, each with its kind and that name."""
        for key, below in self.properties.items():
            if below is not None and below.otherwise and key not in entry:
                with suppress(KeyError):  # what it follows from is missing, too
                    yield key, below.gives, below.otherwise.format_map(texts(entry))


def texts(entry: Mapping[str, Any]) -> dict[str, str]:
    """Return those keys of an entry whose values are texts, each with its text."""
    return {key: value for key, value in entry.items() if isinstance(value, str)}


@cache
def sections() -> Mapping[str, Node]:
    """Return what the schema says of each section of a description of which it says something."""
    found = {key: _node(one) for key, one in schema()["properties"].items()}
    return {key: node for key, node in found.items() if node is not None}


@cache
def merged(*how: str, in_parts: bool = False) -> tuple[str, ...]:
    """Return the sections that are joined in one of some ways; with ``in_parts`` those that may stand in a part."""
    return tuple(key for key, node in sections().items() if node.merge in how and (node.in_parts or not in_parts))


@cache
def named_as(kind: str) -> tuple[str, ...]:
    """Return the sections whose keys are the names of things of a kind."""
    return tuple(key for key, node in sections().items() if node.keys is not None and node.keys.gives == kind)


@cache
def of_topic(topic: str) -> tuple[str, ...]:
    """Return the sections of a topic."""
    return tuple(key for key, node in sections().items() if node.topic == topic)


@cache
def of_parts() -> tuple[str, ...]:
    """Return the sections that may stand in a part."""
    return tuple(key for key, node in sections().items() if node.in_parts)


@cache
def of_types() -> tuple[str, ...]:
    """Return the keys of a sensor that a type of sensors may say, in the order of the schema."""
    entries = [node.others for node in sections().values() if node.others is not None]
    return tuple(
        key for entry in entries for key, node in entry.properties.items() if node is not None and node.in_types
    )


def is_one_entry(section: str) -> bool:
    """Say whether a section of a part is one entry, not many by name or in a list."""
    node = sections().get(section)
    return node is not None and node.in_parts and node.merge in ("", WITHIN)


def holds_many(section: str) -> bool:
    """Say whether a section is one entry with entries by name in it, which several parts and files may add to."""
    return section in merged(WITHIN)


def _node(said: Any) -> Node | None:
    """Return what a schema, or what it refers to, says of values; ``None`` if it says nothing."""
    if not isinstance(said, Mapping):
        return None
    base = _definition(said["$ref"].rsplit("/", 1)[1]) if "$ref" in said else None
    found: dict[str, Any] = {WORDS[word]: value for word, value in said.items() if word in WORDS}
    for word, of in (("propertyNames", "keys"), ("additionalProperties", "others"), ("items", "items")):
        if (node := _node(said.get(word))) is not None:
            found[of] = node
    properties = {key: _node(one) for key, one in said.get("properties", {}).items()}
    if any(properties.values()):
        found["properties"] = properties
    if not found:
        return base
    made = (base or Node())._replace(**found)
    below = (made.keys, made.others, made.items, *made.properties.values())
    return made._replace(of=frozenset(_own(made)).union(*(one.of for one in below if one is not None)))


@cache
def _definition(name: str) -> Node | None:
    return _node(schema()["$defs"][name])


def _own(node: Node) -> Iterator[str]:
    """Yield what is looked at because of a place itself."""
    if node.mirror:
        yield MIRROR
    if node.inside:
        yield INSIDE
    if node.spelt:
        yield SPELT
    if node.scope != ROBOT:
        if node.gives and not node.scope:
            yield GIVES
        elif kind := node.names or node.gives:
            yield from (kind, *ALSO.get(kind, ()))


def check_annotations(piece: Any, own: Mapping[str, Any]) -> None:
    """Raise ValueError where a piece of the schema has an annotation that says nothing: no such word, key or unit.

    ``own`` is the schema of the core.
    """
    from rosorin_compile.source.diagnostics import did_you_mean
    from rosorin_compile.source.units import UNITS, parse_unit

    from .expand.mirroring import MIRRORED

    words = {word for word, _ in _said(own)} | ANNOTATIONS
    for word, value in _said(piece):
        if word not in words:
            raise ValueError(f"the schema has no annotation {word}; {did_you_mean(word, sorted(words))}")
        for unit in (value if isinstance(value, list) else [value]) if word == "x-unit" else ():
            if unit and parse_unit(unit) is None:
                raise ValueError(f'x-unit is "{unit}" in its schema, which is no unit; {did_you_mean(unit, UNITS)}')
    for part in _mappings(piece):
        keys = part.get("properties", {})
        for way in part.get(MIRROR, ()):
            if way not in MIRRORED:
                raise ValueError(f'{MIRROR} is "{way}" in its schema; {did_you_mean(way, sorted(MIRRORED))}')
            if not any(key in keys for key in MIRRORED[way].keys):
                raise ValueError(f"{MIRROR} is {way} in its schema, beside no {' and no '.join(MIRRORED[way].keys)}")
        beside = (key for one in keys.values() if isinstance(one, Mapping) for key in one.get("x-attached", ()))
        for key in beside:
            if key not in keys:
                raise ValueError(f'x-attached names "{key}" in its schema; {did_you_mean(key, sorted(keys))}')


def kinds_given(piece: Any) -> set[str]:
    """Return the kinds of things that get their names in a piece of the schema."""
    return {value for word, value in _said(piece) if word == "x-gives"}


def kinds_named(piece: Any) -> set[str]:
    """Return the kinds of things that are named in a piece of the schema."""
    return {value for word, value in _said(piece) if word == "x-names"}


def _mappings(piece: Any) -> Iterator[Mapping[str, Any]]:
    """Yield each mapping of a piece of the schema."""
    if isinstance(piece, Mapping):
        yield piece
    for inner in piece.values() if isinstance(piece, Mapping) else piece if isinstance(piece, list) else ():
        yield from _mappings(inner)


def _said(piece: Any) -> Iterator[tuple[str, Any]]:
    """Yield each annotation of a piece of the schema, with its value."""
    for part in _mappings(piece):
        yield from ((word, value) for word, value in part.items() if word.startswith("x-"))
