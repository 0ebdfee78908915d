"""Naming: which names a fragment of a description gives, of which kind, and what each is called outside of a part."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.elements import found_in
from rosorin_compile.source.xml.mujoco import BODY, EQUALITY, GEOM, SITE, given, used
from rosorin_compile.source.xml.references import named_in

from ..annotations import ALSO, GIVES, INSIDE, Node, sections

MOUNT = "mount"

# What elements of a URDF name, what a simulation knows by name, and what the parameters of controllers name.
IN_URDF = ("link", "joint")
IN_PARAMETERS = ("link", "joint", "sensor", "hardware block", "hardware sensor", "gpio", "controller")
THINGS = (
    *("link", "joint", "sensor", "servo group", "pose"),
    *("actuator", "tendon", "constraint", "sensor of MuJoCo", "site", "camera", "light"),
)
_ELEMENT = "element"  # whatever an element of MJCF is, beside its kind
KINDS = {BODY: "link", GEOM: "shape", EQUALITY: "constraint"}  # MuJoCo's words for ours
# Names that the MJCF makes of that of a link, and ends of those that it makes of one of a joint of several positions.
_MADE = re.compile(r"(.+)_(?:collision|visual)_\d+")
ENDS = {"planar": ("_TX", "_TY", "_RZ"), "floating": ("_TX", "_TY", "_TZ", "_R")}


@dataclass(frozen=True)
class Names:
    """The names that a fragment gives, by kind.

    ``mounted``: anything in it sits on the mount, or names it; ``inside``: there are values that hold names.
    """

    of: Mapping[str, frozenset[str]]
    mounted: bool
    inside: bool

    def among(self, kinds: Iterable[str]) -> frozenset[str]:
        """Return the names of some kinds."""
        return frozenset().union(*(self.of.get(kind, ()) for kind in kinds))

    @cached_property
    def in_urdf(self) -> frozenset[str]:
        """The names that elements of a URDF may use."""
        return self.among(IN_URDF)

    @cached_property
    def in_mjcf(self) -> frozenset[str]:
        """The names that elements of MJCF may use."""
        return self.among((*THINGS, "material", _ELEMENT))

    @cached_property
    def in_parameters(self) -> frozenset[str]:
        """The names that parameters of controllers may use."""
        return self.among(IN_PARAMETERS)

    def gives(self, kind: str, name: str) -> bool:
        """Say whether the fragment gives a name of a kind, also one that follows from another: LINK_collision_1."""
        if any(name in self.of.get(one, ()) for one in (kind, *ALSO.get(kind, ()))):
            return True
        return kind == "shape" and self.makes(name)

    def makes(self, name: str) -> bool:
        """Say whether the MJCF makes a name of that of a link of the fragment."""
        found = _MADE.fullmatch(name)
        return found is not None and found[1] in self.of.get("link", ())


def names_of(fragment: Map) -> Names:
    """Return the names that a fragment of a description gives, those of its elements of MJCF too."""
    found: dict[str, set[str]] = {}
    inside = [one for node, value in _sections(fragment) for one in _inside(node, value)]
    for kind, name in _given(fragment, inside):
        found.setdefault(kind, set()).add(name)
    mounted = any(_mentions_mount(*one) for one in _sections(fragment)) or any(_uses_mount(*one) for one in inside)
    return Names({kind: frozenset(names) for kind, names in found.items()}, mounted, bool(inside))


def _sections(fragment: Map) -> Iterator[tuple[Node, Any]]:
    """Yield what the schema says of each section, with the section."""
    for section, value in fragment.items():
        node = sections().get(section)
        if node is not None:
            yield node, value


def _given(fragment: Map, inside: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, str]]:
    for node, value in _sections(fragment):
        yield from _given_at(node, value)
        yield from _ends(node, value)
    for how, value in inside:
        yield from _of_elements(how, value)


def _ends(node: Node, section: Any) -> Iterator[tuple[str, str]]:
    """Yield the names that the MJCF has for a joint that moves in several ways."""
    if node.keys is not None and node.keys.gives == "joint" and isinstance(section, Map):
        for name, joint in section.items():
            ends = ENDS.get(str(joint.get("type")), ()) if isinstance(joint, Map) else ()
            yield from (("joint", name + end) for end in ends)


def _of_elements(inside: str, text: str) -> Iterator[tuple[str, str]]:
    """Yield the names that elements of MJCF give, by kind and as what they are: an element."""
    if inside in ("mjcf", "mjcf_body") and isinstance(text, str):
        for one in (one for found in found_in(text) for one in given(found, inside == "mjcf") if one.attribute):
            yield from ((KINDS.get(one.kind, one.kind), one.name), (_ELEMENT, one.name))


def _given_at(node: Node, value: Any) -> Iterator[tuple[str, str]]:
    """Yield the names that are given at a place or below it, each after its kind."""
    if isinstance(value, str):
        if node.gives and not node.scope:
            yield node.gives, value
        return
    keys = node.keys
    if isinstance(value, Map) and keys is not None and keys.gives and not keys.scope:
        yield from ((keys.gives, name) for name in value)
    if isinstance(value, Map):
        yield from ((kind, name) for _, kind, name in node.left_out(value))
    for below, inner in _below(node, value, GIVES):
        yield from _given_at(below, inner)


def _below(node: Node, value: Any, wanted: str) -> Iterator[tuple[Node, Any]]:
    """Yield what is in a value, with what the schema says of it, where that has something to do with what is wanted."""
    if isinstance(value, Map):
        for key, inner in value.items():
            below = node.at(key)
            if below is not None and wanted in below.of:
                yield below, inner
    elif isinstance(value, list) and node.items is not None and wanted in node.items.of:
        yield from ((node.items, inner) for inner in value)


def _inside(node: Node, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the values that hold names, each after the annotation that says how."""
    if node.inside and value:
        yield node.inside, value
    for below, inner in _below(node, value, INSIDE):
        yield from _inside(below, inner)


def _mentions_mount(node: Node, value: Any) -> bool:
    """Say whether a value, or anything in it, is attached to the mount or names it; elements of XML aside."""
    if node.names == "link" and value == MOUNT:
        return True
    if isinstance(value, Map) and node.keys is not None and node.keys.names == "link" and MOUNT in value:
        return True
    return any(_mentions_mount(*one) for one in _below(node, value, "link"))


def _uses_mount(inside: str, text: Any) -> bool:
    """Say whether a value that holds names uses that of the mount."""
    if not isinstance(text, str) or MOUNT not in text:
        return False
    if inside == "urdf":
        return any(found.name == MOUNT and found.sure for found in named_in(text))
    if inside not in ("mjcf", "mjcf_body"):
        return False
    uses = (one for found in found_in(text) for one in used(found, inside == "mjcf"))
    return any(one.name == MOUNT and one.kind in (BODY, SITE) for one in uses)
