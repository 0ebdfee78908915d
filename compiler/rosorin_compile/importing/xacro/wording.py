"""Wording: elements of a file or a part that say the same for every combination of arguments become words.

What has an expression in it stays as it stands. The words are those of the flat import (see ``words``), looked for in
the first robot that has the element; whether the description then says the same is proven as everything else is.

A hardware block with expressions is read with numbers in their place that nothing else has; where such a number comes
out, the expression stands.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.source.tree import Map, Seq, Text
from rosorin_compile.source.xml.elements import canonical, tree_of

from ..description import _Document
from ..layout import Expression, Verbatim
from ..words import Worded, worded
from ..words.blocks import Unsayable, block
from ..words.report import told_words
from ..words.taking import CONTROL, SENSORS, candidates, put, trees, without
from .expressions import negated, written

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Joint, Robot

EXPRESSION = re.compile(r"\$\{([^{}]*)\}")
_FIRST = 731_001  # numbers that stand for expressions, and on, with the same digits behind the point
# The file of a description, the number of the element among those at its top; or among those of a part, with its name.
Spot = tuple[Any, ...]
OPTIONS = {CONTROL: "control", SENSORS: "gazebo"}
_ANY = "ANY_TEXT"
MAX_WHOLE = 90  # letters of an element that stands in one line
_CALLED = {CONTROL: "hardware block", SENSORS: "sensor", "drive": "drive", "edges": "transform"}
_OF_PLUGINS = ("drive", "publishers", "edges")


class Entry(NamedTuple):
    """One entry that an element becomes: its section, its name (empty for a whole section or an item of a list)."""

    section: str
    name: str
    value: Any
    called: str
    comments: tuple[str, ...] = ()


class Words(NamedTuple):
    """What an element becomes: entries, and the text that is left of it.

    ``text`` is the whole element, ``said`` that with its values where it has expressions.
    """

    text: str
    entries: tuple[Entry, ...]
    rest: str
    said: str = ""


class Found(NamedTuple):
    """The elements that become words, what the outputs then ask for, and why others stay."""

    spots: Mapping[Spot, Words] = {}
    options: Mapping[str, Any] = {}
    kept: Mapping[str, str] = {}
    remarks: tuple[str, ...] = ()

    def without(self, blamed: str) -> Found:
        """Return this without the elements that a fault names; if it names none, without those of parts, or any."""
        names = set(re.findall(r"[\w./-]+", blamed))
        wrong = {spot for spot, one in self.spots.items() if any(entry.called in names for entry in one.entries)}
        wrong = wrong or {
            spot for spot, one in self.spots.items() if names & set(re.findall(r'(?:name|reference)="(.*?)"', one.text))
        }
        in_parts = {spot for spot in self.spots if len(spot) > len(("file", "number"))}
        evaluated = {spot for spot, one in self.spots.items() if "${" in one.text}
        gone = wrong or in_parts or evaluated or self.spots.keys()
        return self._replace(spots={spot: one for spot, one in self.spots.items() if spot not in gone})

    def left_of(self, tree: Map) -> Map:
        """Return the tree of a robot without the elements that became words."""
        gone = [one for one in self.spots.values() if one.rest != one.text]
        whole = {_spelt(one.said or one.text): one.rest for one in gone}
        texts = tree.get("urdf_elements") or Seq(tree.span)
        left = Seq(tree.span)
        for text, span in zip(texts, texts.value_spans, strict=True):
            rest = whole.get(_spelt(text), text)
            if rest:
                left.put(Text(rest), span)
        return put(tree, {"urdf_elements": left})


def find(plain: Mapping[Spot, str], evaluated: Mapping[Spot, str], robots: Sequence[Imported]) -> Found:
    """Return which elements become which words, from the first robot that has each.

    Of those with expressions in them (``evaluated``) hardware blocks, and what plug-ins, which stay, say of the drive
    and of transforms, where that is the same in all robots.
    """
    made, left = Found(), {spot: text for spot, text in plain.items() if _may_be_words(text)}
    for imported in robots:
        if imported.tree is None or not left:
            continue
        there = {_spelt(text) for text in imported.tree.get("urdf_elements") or ()}
        here = {spot: text for spot, text in left.items() if _spelt(text) in there}
        left = {spot: text for spot, text in left.items() if spot not in here}
        if here:
            made = _more(made, here, imported)
    more = [(spot, _evaluated(text, robots, made)) for spot, text in evaluated.items() if _may_be_words(text)]
    found = {spot: words for spot, words in more if words is not None}
    asked = {"control": "jazzy"} if any(not words.rest for words in found.values()) else {}
    return made._replace(spots={**made.spots, **found}, options={**asked, **made.options})


def _evaluated(text: str, robots: Sequence[Imported], made: Found) -> Words | None:
    form = EXPRESSION.sub(_ANY, text)
    if "${" in form:
        return None
    pattern = re.escape(_spelt(form)).replace(_ANY, '[^<>"]*')
    found: list[tuple[str, Imported]] = []
    for imported in robots:
        texts = (imported.tree.get("urdf_elements") if imported.tree is not None else None) or ()
        mine = [str(one) for one in texts if re.fullmatch(pattern, _spelt(one))]
        if len(mine) > 1:
            return None
        found += [(one, imported) for one in mine]
    if not found:
        return None
    if text.startswith("<ros2_control"):
        return _block(text, *found[0], made.options.get("control") == "humble")
    entries = _always([tuple(_of_plugins(*one)) for one in found])
    return Words(text, entries, text, found[0][0]) if entries else None


def _block(text: str, said: str, imported: Imported, humble: bool) -> Words | None:
    tree: Any = imported.tree
    robot = imported.robot
    found = symbolic(text, said, robot, humble) if robot is not None else None
    if found is None:
        return None
    name, entry, slots = found
    whole = put(tree, {CONTROL: {name: entry}})
    value = with_expressions(_document(whole).value(whole[CONTROL][name], (CONTROL, name), None), slots)
    made = Entry(CONTROL, with_expressions(name, slots), value, tree_of(said).get("name", ""))
    return Words(text, (made,), "", said)


def _always(found: Sequence[tuple[Entry, ...]]) -> tuple[Entry, ...]:
    same = [entry for entry in found[0] if all(entry in others for others in found)]
    # a radius that the element reckons is one that it keeps
    return tuple(entry for entry in same if entry.section != "drive" or "radius" not in entry.value)


def _may_be_words(text: str) -> bool:
    return any(mark in text for mark in ("<ros2_control", "<sensor", "<plugin"))


@lru_cache(maxsize=8192)  # each is held against those of all robots
def _spelt(text: str) -> str:
    try:
        return canonical(tree_of(text))
    except ValueError:
        return text


def _more(made: Found, here: Mapping[Spot, str], imported: Imported) -> Found:
    tree: Any = imported.tree
    texts = Seq(tree.span)
    for text in here.values():
        texts.put(Text(text), tree.span)
    all_of = worded(imported._replace(tree=put(tree, {"urdf_elements": texts}), comments=()))
    said: Any = all_of.imported.tree
    options = dict((said.get("outputs") or {}).get("urdf") or {})
    fits = {section for section, option in OPTIONS.items() if made.options.get(option) in (None, options.get(option))}
    taken = [one for one in candidates(texts) if one.section in fits and one.name in (said.get(one.section) or {})]
    rest = without(texts, taken)
    spots = dict(made.spots)
    document = _document(said)
    for index, (spot, text) in enumerate(here.items()):
        mine = [one for one in taken if one.text == index]
        entries = [
            Entry(
                one.section,
                one.name,
                document.value(said[one.section][one.name], one.path, None),
                one.name,
                _comments(rest, one.path),
            )
            for one in mine
        ]
        path = rest.paths[index]
        entries += _of_plugins(text, imported)
        if entries:
            left = str(rest.texts[path[1]]) if path[0] == "urdf_elements" else ""  # type: ignore[index]
            left = _laid_out(left) if mine else text
            spots[spot] = Words(text, tuple(entries), left)
    asked = {option: options[option] for section, option in OPTIONS.items() if section in fits and option in options}
    return Found(spots, {**made.options, **asked}, {**made.kept, **all_of.kept}, (*made.remarks, *all_of.remarks))


def _laid_out(text: str) -> str:
    lines = text.splitlines()
    whole = "".join(line.strip() for line in lines)
    if len(lines) == 3 and len(whole) <= MAX_WHOLE and "<!--" not in whole:
        return whole
    return f"{text}\n" if len(lines) > 1 else text


def _comments(rest: Any, path: tuple[str | int, ...]) -> tuple[str, ...]:
    return tuple(one.text for one in rest.comments if one.path == path)


def _document(tree: Map) -> _Document:
    made = _Document(tree)
    made.folders = {}
    return made


def _of_plugins(text: str, imported: Imported) -> Iterator[Entry]:
    tree: Any = imported.tree
    alone = Seq(tree.span)
    alone.put(Text(text), tree.span)
    if not any(child.tag == "plugin" for _, element in trees(alone) for child in element):
        return
    made = worded(imported._replace(tree=put(tree, {"urdf_elements": alone}), comments=()))
    said: Any = made.imported.tree
    document = _document(said)
    for section in _OF_PLUGINS:
        if section not in said or section in tree:
            continue
        value = document.value(said[section], (section,), None)
        if section == "drive":
            yield Entry(section, "", value, ", ".join(made.said.get("drive", ())))
        elif section == "edges":
            names = made.said.get("transform", ())
            yield from (Entry(section, "", one, name) for one, name in zip(value, names, strict=True))
        else:
            yield from (Entry(section, name, one, name) for name, one in value.items())


def wishes(wanted: Outputs, options: Mapping[str, Any]) -> Outputs:
    """Return outputs of which the URDF asks for what words need, and for nothing that there are no words for."""
    entries = dict(wanted.entries)
    if "urdf" in entries:
        plain = {key: value for key, value in entries["urdf"].items() if key not in OPTIONS.values()}
        entries["urdf"] = {**plain, **options}
    return wanted._replace(entries=entries)


def any_of(conditions: Iterable[ast.expr | None]) -> ast.expr | None:
    """Return the condition that one of some conditions holds, told shortly; None where one always does."""
    rows: list[dict[str, ast.expr]] = []
    for one in conditions:
        nodes = [] if one is None else one.values if _is_and(one) else [one]  # type: ignore[attr-defined]
        rows.append({written(node): node for node in nodes})
    rows = _shorter(rows)
    if not rows or any(not row for row in rows):
        return None
    made = [next(iter(row.values())) if len(row) == 1 else ast.BoolOp(ast.And(), list(row.values())) for row in rows]
    return made[0] if len(made) == 1 else ast.BoolOp(ast.Or(), made)


def _is_and(node: ast.expr) -> bool:
    return isinstance(node, ast.BoolOp) and isinstance(node.op, ast.And)


def _shorter(rows: list[dict[str, ast.expr]]) -> list[dict[str, ast.expr]]:
    rows = [row for at, row in enumerate(rows) if not any(_covers(one, row, at > i) for i, one in enumerate(rows))]
    for row in rows:
        for name, node in row.items():
            mate = {**{key: value for key, value in row.items() if key != name}, written(negated(node)): node}
            if any(one is not row and one.keys() == mate.keys() for one in rows):
                joined = {key: value for key, value in row.items() if key != name}
                others = [one for one in rows if one is not row and one.keys() != mate.keys()]
                return _shorter([*others, joined])
    return rows


def _covers(one: dict[str, ast.expr], other: dict[str, ast.expr], earlier: bool) -> bool:
    if one is other:
        return False
    return one.keys() < other.keys() or (one.keys() == other.keys() and earlier)


def wording_report(said: Mapping[str, Sequence[str]], found: Found) -> list[str]:
    """Return the lines about what became words, and about what did not."""
    names = {word: list(dict.fromkeys(said[section])) for section, word in _CALLED.items() if section in said}
    return told_words(Worded(Imported(None, []), None, names, found.kept, found.remarks))


class _Joints(NamedTuple):
    """The joints of a robot by the names that they have with numbers for expressions."""

    joint: Mapping[str, Joint]


def symbolic(text: str, said: str, robot: Robot, humble: bool) -> tuple[str, dict[str, Any], dict[str, str]] | None:
    """Return the name of a block, its entry with numbers for expressions, and these by their numbers; None for none.

    ``said`` is the block with its values, as ``robot`` has it.
    """
    slots: dict[str, str] = {}

    def numbered(found: re.Match[str]) -> str:
        number = f"{_FIRST + len(slots)}.25"
        slots[number] = found[1]
        return number

    form = EXPRESSION.sub(numbered, text)
    if "${" in form or any(number in text for number in slots):
        return None
    element, known = tree_of(form), tree_of(said)
    if element.tag != "ros2_control" or any(_has_text(one) for one in element.iter() if len(one)):
        return None
    joints = {
        one.get("name", ""): robot.joint[other.get("name", "")]
        for one, other in zip(element.iter("joint"), known.iter("joint"), strict=False)
        if other.get("name", "") in robot.joint
    }
    try:
        return element.get("name", ""), block(element, _Joints(joints), humble), slots  # type: ignore[arg-type]
    except Unsayable:
        return None


def _has_text(element: Element) -> bool:
    return bool((element.text or "").strip()) or any((child.tail or "").strip() for child in element)


def with_expressions(value: Any, slots: Mapping[str, str]) -> Any:
    """Return what is laid out with expressions for their numbers."""
    if isinstance(value, dict):
        return {with_expressions(key, slots): with_expressions(item, slots) for key, item in value.items()}
    if isinstance(value, list):
        return [with_expressions(item, slots) for item in value]
    if not isinstance(value, str) or not any(number in value for number in slots):
        return value
    sole = slots.get(value.removeprefix("-"))
    if isinstance(value, Verbatim) and sole is not None and value.startswith("-"):
        return Expression(f"${{-({sole})}}")
    made = str(value)
    for number, expression in slots.items():
        made = made.replace(number, f"${{{expression}}}")
    return Expression(made)
