"""The symbol table: which names a description defines, which it refers to, and where.

The schema declares both (``x-gives`` and ``x-names``, see ``annotations``). Prefixes in parts, renaming, rules about
unknown names, suggestions and completion use this table; nothing else searches a description for names.
``values`` is its counterpart for names in expressions: arguments, named values, parts and parameters.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.xml.elements import found_in

from .annotations import ALSO, GIVES, INSIDE, SPELT, Node
from .element_names import BODY, EQUALITY, GEOM, SITE, given, named_in, used
from .schema import sections

MOUNT = "mount"

# Kinds that elements of a URDF, of MJCF, parameters of controllers and a simulation refer to.
IN_URDF = ("link", "joint")
IN_PARAMETERS = ("link", "joint", "sensor", "hardware block", "hardware sensor", "gpio", "controller")
THINGS = (
    *("link", "joint", "sensor", "servo group", "pose"),
    *("actuator", "tendon", "constraint", "sensor of MuJoCo", "site", "camera", "light"),
)
_ELEMENT = "element"  # any named element of MJCF, in addition to its kind
IN_MJCF = (*THINGS, "material", _ELEMENT)
KINDS = {BODY: "link", GEOM: "shape", EQUALITY: "constraint"}  # MuJoCo's words for kinds
# Names that the MJCF derives from that of a link, and suffixes of those that it derives from that of a joint.
_DERIVED = re.compile(r"(.+)_(?:collision|visual)_\d+")
ENDS = {"planar": ("_TX", "_TY", "_RZ"), "floating": ("_TX", "_TY", "_TZ", "_R")}


class _Occurrence(NamedTuple):
    """A text, or the key of a mapping (``key``), that the schema calls a name, or a value that contains names."""

    node: Node
    value: Any
    path: Path
    key: bool = False


def _walk(node: Node, value: Any, path: Path, wanted: Collection[str], rules: bool = False) -> Iterator[_Occurrence]:
    """Yield names below a value, in the order of the description; only where the schema has something ``wanted``.

    With ``rules``, names that have rules of their own (``x-said`` is false) are left out.
    """
    if rules and node.said is False:
        return
    if isinstance(value, str):
        yield _Occurrence(node, value, path)
        return
    if node.inside and value:
        yield _Occurrence(node, value, path)
    if isinstance(value, Map):
        if node.keys is not None:
            for name in value:
                yield _Occurrence(node.keys, name, (*path, name), True)
        if GIVES in wanted:
            for key, kind, name in node.left_out(value):
                yield _Occurrence(Node(gives=kind), name, (*path, key))
        for key, item in value.items():
            below = node.at(key)
            if below is not None and (not wanted or not below.of.isdisjoint(wanted)):
                yield from _walk(below, item, (*path, key), wanted, rules)
    elif isinstance(value, list) and node.items is not None and (not wanted or not node.items.of.isdisjoint(wanted)):
        for index, item in enumerate(value):
            yield from _walk(node.items, item, (*path, index), wanted, rules)


@dataclass(frozen=True)
class Reference:
    """A use or the definition of a name; ``key``: a key of the description is the name. ``what`` describes a use.

    ``among`` is where the name is looked up: "" for all names of the description.
    """

    kind: str
    name: str
    path: Path
    key: bool
    what: str = ""
    among: str = ""


class SymbolTable:
    """The names that a tree defines and refers to."""

    def __init__(self, tree: Map) -> None:
        self.tree = tree

    def _occurrences(self, wanted: Collection[str], section: str = "", rules: bool = False) -> Iterator[_Occurrence]:
        for name, node in sections().items():
            value = self.tree.get(name) if section in ("", name) else None
            if value is not None and (not wanted or not node.of.isdisjoint(wanted)):
                yield from _walk(node, value, (name,), wanted, rules)

    def definitions(self, section: str = "", implied: bool = False) -> Iterator[Reference]:
        """Yield the names that are defined, in one section or in all; ``implied``: also those of keys left out."""
        for node, name, path, key in self._occurrences((GIVES, "link") if implied else (), section):
            if node.gives and isinstance(name, str):
                yield Reference(node.gives, name, path, key)

    def references(self, kinds: Collection[str] = (), section: str = "") -> Iterator[Reference]:
        """Yield the uses of names of some kinds, or of all, in the order of the schema and of the description."""
        for node, name, path, key in self._occurrences(kinds, section, rules=True):
            if node.names and node.said is not False and isinstance(name, str) and (not kinds or node.names in kinds):
                what = node.said.format(*path) if node.said else f"the {path[-1]} of {_entry(path)}"
                yield Reference(node.names, name, path, key, what, node.among)

    def spelt(self) -> Iterator[tuple[str, str, Path, bool]]:
        """Yield the texts and keys whose words are compared with usual ones (``x-spelt``), each with what it is."""
        for node, name, path, key in self._occurrences((SPELT,)):
            if node.spelt and isinstance(name, str):
                yield node.spelt, name, path, key

    def names(self) -> Names:
        """Return the names that the tree defines, also within elements of MJCF."""
        found: dict[str, set[str]] = {}
        mounted = inside = False
        for node, value, _, _ in self._occurrences((GIVES, INSIDE, "link")):
            if node.gives and not node.scope and isinstance(value, str):
                found.setdefault(node.gives, set()).add(value)
            mounted = mounted or (node.names == "link" and value == MOUNT)
            if node.inside:
                inside = True
                mounted = mounted or _uses_mount(node.inside, value)
                elements = found_in(value) if node.inside in ("mjcf", "mjcf_body") and isinstance(value, str) else ()
                for one in (one for element in elements for one in given(element, node.inside == "mjcf")):
                    for kind in (KINDS.get(one.kind, one.kind), _ELEMENT) if one.attribute else ():
                        found.setdefault(kind, set()).add(one.name)
        for section, node in sections().items():
            entries = self.tree.get(section) if node.keys is not None and node.keys.gives == "joint" else None
            for name, entry in entries.items() if isinstance(entries, Map) else ():
                ends = ENDS.get(str(entry.get("type")), ()) if isinstance(entry, Map) else ()
                found.setdefault("joint", set()).update(name + end for end in ends)
        return Names({kind: frozenset(names) for kind, names in found.items()}, mounted, inside)


@dataclass(frozen=True)
class Names:
    """The names that a fragment of a description defines, by kind."""

    of: Mapping[str, frozenset[str]]
    mounted: bool
    inside: bool

    def among(self, kinds: Iterable[str]) -> frozenset[str]:
        """Return the names of some kinds."""
        return frozenset().union(*(self.of.get(kind, ()) for kind in kinds))

    def gives(self, kind: str, name: str) -> bool:
        """Return True if the fragment defines a name of a kind, or the MJCF derives it: LINK_collision_1."""
        if any(name in self.of.get(one, ()) for one in (kind, *ALSO.get(kind, ()))):
            return True
        return kind == "shape" and self.makes(name)

    def makes(self, name: str) -> bool:
        """Return True if the MJCF derives a name from that of a link of the fragment."""
        found = _DERIVED.fullmatch(name)
        return found is not None and found[1] in self.of.get("link", ())


def _entry(path: Path) -> str:
    section = sections()[str(path[0])]
    if len(path) > 2 and isinstance(path[1], int):
        return f"{path[0]}[{path[1]}]"
    by_name = section.keys is not None or section.others is not None
    return f'{section.called or path[0]} "{path[1]}"' if len(path) > 2 and by_name else section.called or str(path[0])


def _uses_mount(inside: str, text: Any) -> bool:
    if not isinstance(text, str) or MOUNT not in text:
        return False
    if inside == "urdf":
        return any(found.name == MOUNT and found.sure for found in named_in(text))
    if inside not in ("mjcf", "mjcf_body"):
        return False
    uses = (one for found in found_in(text) for one in used(found, inside == "mjcf"))
    return any(one.name == MOUNT and one.kind in (BODY, SITE) for one in uses)
