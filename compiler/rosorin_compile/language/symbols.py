"""The symbol table: the names that a description defines and refers to, with their paths.

The table of an expanded tree has the names that the schema marks with ``x-gives`` and ``x-names`` (``annotations``).
The table of the files as written also has arguments, named values, parts, parameters and sensor types, independent of
the arguments of the run: names in a branch that is not taken count as used. The table is used for prefixes, rules
about unknown, unused and similar names, ``explain``, suggestions and completion.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map, Path, Place, Seq
from rosorin_compile.source.xml.elements import found_in

from .annotations import ALSO, GIVES, INSIDE, SPELT, Node
from .element_names import BODY, EQUALITY, GEOM, SITE, defined_names, named_in, used_names
from .expression import all_names, pieces
from .schema import named_as, sections

MOUNT = "mount"

# Kinds of names to which URDF elements, controller parameters, MJCF elements and simulations may refer.
IN_URDF = ("link", "joint")
IN_PARAMETERS = ("link", "joint", "sensor", "hardware block", "hardware sensor", "gpio", "controller")
THINGS = (
    *("link", "joint", "sensor", "servo group", "pose"),
    *("actuator", "tendon", "constraint", "sensor of MuJoCo", "site", "camera", "light"),
)
_ELEMENT = "element"  # pseudo kind of all named MJCF elements
IN_MJCF = (*THINGS, "material", _ELEMENT)
KINDS = {BODY: "link", GEOM: "shape", EQUALITY: "constraint"}  # kinds of names by MJCF tag
# In the MJCF, shapes are named after their link, and planar and floating joints become joints with these suffixes.
_DERIVED = r"(.+)_(?:collision|visual)_\d+"
ENDS = {"planar": ("_TX", "_TY", "_RZ"), "floating": ("_TX", "_TY", "_TZ", "_R")}
# Sections whose entries have local names, with (kind of entry, local names that are always defined).
_OWNERS = {"parts": ("part", ("name", "mirrored")), "sensor_types": ("sensor type", ("name", "frame", "parent"))}
WORD = re.compile(r"[^\W\d]\w*")
# A name, or a value that contains names, as (annotations, value, path, True for a key).
_Occurrence = tuple[Node, Any, Path, bool]
Condition = Callable[[Any], bool]


def _walk(node: Node, value: Any, path: Path, wanted: Collection[str], rules: bool, found: list[_Occurrence]) -> None:
    """Add the names below a value that have one of the annotations ``wanted`` (all if empty), in file order."""
    if rules and node.said is False:
        return
    if isinstance(value, str) or (node.inside and value):
        found.append((node, value, path, False))
    if isinstance(value, Map):
        if "value" in value and ("for" in value or "if" in value):  # an entry before expansion
            _walk(node, value["value"], path, wanted, rules, found)
        if node.keys is not None:
            found += [(node.keys, name, (*path, name), True) for name in value]
        if GIVES in wanted:
            found += [(Node(gives=kind), name, (*path, key), False) for key, kind, name in node.left_out(value)]
        for key, item in value.items():
            below = node.value_of(key)
            if below is not None and (not wanted or not below.of.isdisjoint(wanted)):
                _walk(below, item, (*path, key), wanted, rules, found)
    elif isinstance(value, list) and node.items is not None and (not wanted or not node.items.of.isdisjoint(wanted)):
        for index, item in enumerate(value):
            _walk(node.items, item, (*path, index), wanted, rules, found)


class Symbol(NamedTuple):
    """A definition of a name, or a reference to a name; ``key`` is True if the name is a key, not a value.

    ``what`` describes a reference for messages. ``among`` is "simulation" or "description" if the name is looked up
    only there. ``place`` is set for names that exist only before expansion, ``owner`` if they are local to a part or
    sensor type.
    """

    kind: str
    name: str
    path: Path = ()
    key: bool = False
    what: str = ""
    among: str = ""
    place: Place | None = None
    owner: str = ""


class Contents(NamedTuple):
    """What a tree contains. ``names`` maps kinds to the names that it defines, including names in MJCF elements."""

    names: Mapping[str, Collection[str]]
    uses_mount: bool  # something is attached to the frame ``mount``
    may_hide_names: bool  # there are XML elements, parameters or conditions, which may contain names


class SymbolTable:
    """The names that a tree defines and refers to.

    ``tree`` is the expanded tree, or the joined files before expansion. For files, pass their ``let`` sections, the
    arguments of their includes, and a function that returns True for values without expressions.
    """

    def __init__(
        self, tree: Map, lets: Sequence[Map] = (), offered: Sequence[Map] = (), is_constant: Condition | None = None
    ) -> None:
        self.tree, self.lets, self.offered = tree, lets, offered
        self.of_files, self.is_constant = is_constant is not None, is_constant or (lambda _: True)

    def _fragments(self) -> Iterator[tuple[Path, Map]]:
        """Yield (path, mapping) of the tree, of each part, and of the key ``content`` of each ``use`` entry."""
        waiting: list[tuple[Path, Map]] = [((), self.tree)]
        waiting += [(("parts", name), body) for name, body in _entries(self.tree, "parts")]
        for path, fragment in waiting:
            yield path, fragment
            for name, entry in _entries(fragment, "use"):
                if isinstance(entry.get("content"), Map):
                    waiting.append(((*path, "use", name, "content"), entry["content"]))

    def _occurrences(self, wanted: Collection[str], section: str = "", rules: bool = False) -> list[_Occurrence]:
        nodes, found = sections(), list[_Occurrence]()
        for path, fragment in self._fragments():
            for name, node in nodes.items():
                value = fragment.get(name) if section in ("", name) else None
                if value is not None and (not wanted or not node.of.isdisjoint(wanted)):
                    _walk(node, value, (*path, name), wanted, rules, found)
        sensor = nodes["sensors"].others or Node()
        for name, body in _entries(self.tree, "sensor_types") if not section else ():
            _walk(sensor, body, ("sensor_types", name), wanted, rules, found)
        return found

    def definitions(self, section: str = "", implied: bool = False) -> Iterator[Symbol]:
        """Yield the definitions in a section (default: all); with ``implied``, also default names for missing keys."""
        for node, name, path, key in self._occurrences((GIVES, "link") if implied else (), section):
            if node.gives and isinstance(name, str):
                yield Symbol(node.gives, name, path, key)
        if self.of_files and not section:
            yield from _keys(self.tree.get("args"), "argument")
            yield from _keys(self.tree.get("use"), "use")
            yield from (symbol for lets in self.lets for symbol in _keys(lets, "value"))
            for owners, (kind, _) in _OWNERS.items():
                yield from _keys(self.tree.get(owners), kind)
                for name, body in _entries(self.tree, owners):
                    yield from _keys(body.get("params"), "parameter", f'{kind} "{name}"')
                    yield from _keys(body.get("let"), "value", f'{kind} "{name}"')

    def references(self, kinds: Collection[str] = (), section: str = "") -> Iterator[Symbol]:
        """Yield the references to names of some kinds, by default of all kinds, in the order of the schema.

        Before expansion, arguments, named values and parameters have the kind "value"; a name with "$" is yielded for
        each possible kind. References to modes are yielded only if ``kinds`` contains "mode".
        """
        wanted = {*kinds, INSIDE} if "mode" in kinds else kinds
        for node, name, path, key in self._occurrences(wanted, section, rules=not self.of_files):
            if not isinstance(name, str):
                continue
            if node.inside == "condition" and "mode" in kinds:
                yield from (Symbol("mode", word, path) for word in WORD.findall(name))
            if node.names and (self.of_files or node.said is not False) and (not kinds or node.names in kinds):
                what = node.said.format(*path) if node.said else f"the {path[-1]} of {_entry(path)}"
                yield Symbol(node.names, name, path, key, what, node.among)
            elif self.of_files and "$" in name and node.inside in ("", "condition"):
                marks = {kind: INSIDE if kind == "mode" else kind for kind in kinds}
                yield from (Symbol(kind, name, path, key) for kind, mark in marks.items() if mark in node.of)
        if self.of_files and "value" in kinds:
            yield from self._in_files()
        if self.of_files and "part" in kinds:
            for path, fragment in self._fragments():
                for name, entry in _entries(fragment, "use"):
                    item = entry.get("value", entry)
                    if isinstance(item, Map) and isinstance(item.get("part"), str):
                        yield Symbol("part", item["part"], (*path, "use", name, "part"))
        for robot in self.offered if "publisher" in kinds else ():
            if isinstance(robot.get("publisher"), str):
                yield Symbol("publisher", robot["publisher"])

    def _in_files(self) -> Iterator[Symbol]:
        for section, (kind, built_in) in _OWNERS.items():
            for name, body in _entries(self.tree, section):
                inner = [one.name for key in ("params", "let") for one in _keys(body.get(key), "")]
                owners = dict.fromkeys((*built_in, *inner), f'{kind} "{name}"')
                yield from self._in_expressions(body, Place(body.span, body.via), owners)
        for key, value in self.tree.items():
            if key not in (*_OWNERS, "modes"):
                yield from self._in_expressions(value, Place(self.tree.value_spans[key], self.tree.via), {})
        for table in (*self.lets, *self.offered):
            yield from self._in_expressions(table, Place(table.span, table.via), {})

    def _in_expressions(self, value: Any, place: Place, owners: Mapping[str, str | None]) -> Iterator[Symbol]:
        if self.is_constant(value):
            return
        if isinstance(value, str):
            for name in {name for piece in pieces(value) if piece.is_expression for name in all_names(piece.text)}:
                if (owner := owners.get(name, "")) is not None:
                    yield Symbol("value", name, place=place, owner=owner)
        elif isinstance(value, Seq):
            for item, span in zip(value, value.value_spans, strict=True):
                yield from self._in_expressions(item, Place(span, value.via), owners)
        else:
            inner = {**owners, **_loop_names(value)}
            for key, item in value.items():
                at = Place(value.value_spans[key], value.via)
                if key == "for" and isinstance(item, Map):
                    yield from self._in_expressions(item, at, owners)
                elif key != "help":
                    name_place = Place(value.key_spans[key], value.via)
                    yield from self._in_expressions(key, name_place, {**inner, **_loop_names(item)})
                    yield from self._in_expressions(item, at, inner)

    def spelt(self) -> Iterator[tuple[str, str, Path, bool]]:
        """Yield (description, word, path, True for a key) of each word to check for spelling mistakes."""
        for node, name, path, key in self._occurrences((SPELT,)):
            if node.spelt and isinstance(name, str):
                yield node.spelt, name, path, key

    @cached_property
    def contents(self) -> Contents:
        found: dict[str, set[str]] = defaultdict(set)
        mounted = inside = False
        for node, value, _, _ in self._occurrences((GIVES, INSIDE, "link")):
            if node.gives and not node.scope and isinstance(value, str):
                found[node.gives].add(value)
            mounted = mounted or (node.names == "link" and value == MOUNT)
            if node.inside:
                inside = True
                text, top = value if isinstance(value, str) else "", node.inside == "mjcf"
                if node.inside == "urdf" and MOUNT in text:
                    mounted = mounted or any(one.name == MOUNT and one.sure for one in named_in(text))
                for element in found_in(text) if node.inside in ("mjcf", "mjcf_body") else ():
                    for one in used_names(element, top) if MOUNT in text else ():
                        mounted = mounted or (one.name == MOUNT and one.kind in (BODY, SITE))
                    for one in (one for one in defined_names(element, top) if one.attribute):
                        found[KINDS.get(one.kind, one.kind)].add(one.name)
                        found[_ELEMENT].add(one.name)
        for section in named_as("joint"):
            for name, entry in _entries(self.tree, section):
                found["joint"].update(name + end for end in ENDS.get(str(entry.get("type")), ()))
        return Contents(dict(found), mounted, inside)

    def names_of_kinds(self, kinds: Iterable[str]) -> frozenset[str]:
        """Return the names of several kinds, such as "link" and "joint"."""
        return frozenset().union(*(self.contents.names.get(kind, ()) for kind in kinds))

    def defines(self, kind: str, name: str) -> bool:
        """Return True if the tree defines a name of a kind, or the MJCF will, such as the shape LINK_collision_1."""
        if any(name in self.contents.names.get(one, ()) for one in (kind, *ALSO.get(kind, ()))):
            return True
        return kind == "shape" and self.makes(name)

    def makes(self, name: str) -> bool:
        """Return True if the MJCF will have a shape with this name, such as LINK_visual_1 for the link LINK."""
        found = re.fullmatch(_DERIVED, name)
        return found is not None and found[1] in self.contents.names.get("link", ())


def _entry(path: Path) -> str:
    section = sections().get(str(path[0]), Node())
    if len(path) > 2 and isinstance(path[1], int):
        return f"{path[0]}[{path[1]}]"
    by_name = section.keys is not None or section.others is not None
    return f'{section.called or path[0]} "{path[1]}"' if len(path) > 2 and by_name else section.called or str(path[0])


def _entries(tree: Map, section: str) -> list[tuple[str, Map]]:
    owner = tree.get(section)
    return [item for item in owner.items() if isinstance(item[1], Map)] if isinstance(owner, Map) else []


def _keys(table: Any, kind: str, owner: str = "") -> Iterator[Symbol]:
    """Yield the keys of a table as definitions; a key such as ``box(x, y)`` defines the function box."""
    for key in table if isinstance(table, Map) else ():
        yield Symbol(kind, key.partition("(")[0], key=True, place=Place(table.key_spans[key], table.via), owner=owner)


def _loop_names(entry: Any) -> dict[str, None]:
    loops = entry.get("for") if isinstance(entry, Map) else None
    return dict.fromkeys(name.strip() for names in loops for name in names.split(",")) if isinstance(loops, Map) else {}
