"""Turn elements of XML without expressions into entries of the language, as for an imported URDF."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from rosorin_compile.formats.imported import Imported, Outputs
from rosorin_compile.source.tree import Map, Seq, Text
from rosorin_compile.source.xml.elements import canonical, tree_of

from ..description import _Document
from ..words import Worded, told_words, worded
from ..words.taking import CONTROL, SENSORS, candidates, put, trees, without

# The file of a description, the number of the element among those at its top; or the same of a part, with its name.
Spot = tuple[Any, ...]
OPTIONS = {CONTROL: "control", SENSORS: "gazebo"}
_MARKS = ("<ros2_control", "<sensor", "<plugin")
_TITLES = {CONTROL: "hardware block", SENSORS: "sensor", "drive": "drive", "edges": "transform"}
_OF_PLUGINS = ("drive", "publishers", "edges")
_ONE_LINE = 90  # letters of an element that is written in one line


class Entry(NamedTuple):
    """An entry that an element becomes: its section, its name (empty for a whole section or an item of a list)."""

    section: str
    name: str
    value: Any
    label: str
    comments: tuple[str, ...] = ()


class Words(NamedTuple):
    """What an element becomes: entries, and the text that is left of it."""

    text: str
    entries: tuple[Entry, ...]
    rest: str


class Found(NamedTuple):
    """The elements that become entries, the options of outputs that those need, and why others stay."""

    spots: Mapping[Spot, Words] = {}
    options: Mapping[str, Any] = {}
    kept: Mapping[str, str] = {}
    remarks: tuple[str, ...] = ()

    def without(self, blamed: str) -> Found:
        """Return this without the elements that a fault names; if it names none, without those of parts, or any."""
        names = set(re.findall(r"[\w./-]+", blamed))
        wrong = {
            spot
            for spot, one in self.spots.items()
            if any(entry.label in names for entry in one.entries)
            or names & set(re.findall(r'(?:name|reference)="(.*?)"', one.text))
        }
        gone = wrong or {spot for spot in self.spots if len(spot) > len(("file", "number"))} or self.spots.keys()
        return self._replace(spots={spot: one for spot, one in self.spots.items() if spot not in gone})

    def left_of(self, tree: Map) -> Map:
        """Return the tree of a robot without the elements that became entries."""
        whole = {_canonical(one.text): one.rest for one in self.spots.values() if one.rest != one.text}
        texts = tree.get("urdf_elements") or Seq(tree.span)
        left = Seq(tree.span)
        for text, span in zip(texts, texts.value_spans, strict=True):
            rest = whole.get(_canonical(text), text)
            if rest:
                left.put(Text(rest), span)
        return put(tree, {"urdf_elements": left})


def find(plain: Mapping[Spot, str], robots: Sequence[Imported]) -> Found:
    """Return which elements become which entries, from the first robot that has each."""
    made, left = Found(), {spot: text for spot, text in plain.items() if any(mark in text for mark in _MARKS)}
    for imported in robots:
        if imported.tree is None or not left:
            continue
        there = {_canonical(text) for text in imported.tree.get("urdf_elements") or ()}
        here = {spot: text for spot, text in left.items() if _canonical(text) in there}
        left = {spot: text for spot, text in left.items() if spot not in here}
        made = _more(made, here, imported) if here else made
    return made


@lru_cache(maxsize=8192)
def _canonical(text: str) -> str:
    try:
        return canonical(tree_of(text))
    except ValueError:
        return text


def _more(made: Found, here: Mapping[Spot, str], imported: Imported) -> Found:
    tree: Any = imported.tree
    texts = Seq(tree.span)
    for text in here.values():
        texts.put(Text(text), tree.span)
    whole = worded(imported._replace(tree=put(tree, {"urdf_elements": texts}), comments=()))
    result: Any = whole.imported.tree
    options = dict((result.get("outputs") or {}).get("urdf") or {})
    fits = {section for section, option in OPTIONS.items() if made.options.get(option) in (None, options.get(option))}
    taken = [one for one in candidates(texts) if one.section in fits and one.name in (result.get(one.section) or {})]
    rest = without(texts, taken)
    spots = dict(made.spots)
    document = _document(result)
    for index, (spot, text) in enumerate(here.items()):
        mine = [one for one in taken if one.text == index]
        entries = [
            Entry(
                one.section,
                one.name,
                document.value(result[one.section][one.name], one.path, None),
                one.name,
                tuple(comment.text for comment in rest.comments if comment.path == one.path),
            )
            for one in mine
        ]
        path = rest.paths[index]
        entries += _of_plugins(text, imported)
        if entries:
            left = str(rest.texts[path[1]]) if path[0] == "urdf_elements" else ""  # type: ignore[index]
            spots[spot] = Words(text, tuple(entries), _laid_out(left) if mine else text)
    wanted = {option: options[option] for section, option in OPTIONS.items() if section in fits and option in options}
    kept, remarks = {**made.kept, **whole.kept}, (*made.remarks, *whole.remarks)
    return Found(spots, {**made.options, **wanted}, kept, remarks)


def _laid_out(text: str) -> str:
    lines = text.splitlines()
    whole = "".join(line.strip() for line in lines)
    if len(lines) == 3 and len(whole) <= _ONE_LINE and "<!--" not in whole:
        return whole
    return f"{text}\n" if len(lines) > 1 else text


def _document(tree: Map) -> _Document:
    return _Document(tree)


def _of_plugins(text: str, imported: Imported) -> Iterator[Entry]:
    """Yield the entries that a plug-in, which stays, implies: the drive, publishers, transforms."""
    tree: Any = imported.tree
    alone = Seq(tree.span)
    alone.put(Text(text), tree.span)
    if not any(child.tag == "plugin" for _, element in trees(alone) for child in element):
        return
    made = worded(imported._replace(tree=put(tree, {"urdf_elements": alone}), comments=()))
    result: Any = made.imported.tree
    document = _document(result)
    for section in _OF_PLUGINS:
        if section not in result or section in tree:
            continue
        value = document.value(result[section], (section,), None)
        if section == "drive":
            yield Entry(section, "", value, ", ".join(made.said.get("drive", ())))
        elif section == "edges":
            names = made.said.get("transform", ())
            yield from (Entry(section, "", one, name) for one, name in zip(value, names, strict=True))
        else:
            yield from (Entry(section, name, one, name) for name, one in value.items())


def outputs_for(wanted: Outputs, options: Mapping[str, Any]) -> Outputs:
    """Return outputs of which the URDF has the options that entries need, and no others of those."""
    entries = dict(wanted.entries)
    if "urdf" in entries:
        plain = {key: value for key, value in entries["urdf"].items() if key not in OPTIONS.values()}
        entries["urdf"] = {**plain, **options}
    return wanted._replace(entries=entries)


def wording_report(labels: Mapping[str, Sequence[str]], found: Found) -> list[str]:
    """Return the lines about the elements that became entries, and about those that did not."""
    names = {title: list(dict.fromkeys(labels[section])) for section, title in _TITLES.items() if section in labels}
    return told_words(Worded(Imported(None, []), None, names, found.kept, found.remarks))
