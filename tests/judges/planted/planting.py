"""Changes of artifacts, one at a time: each number, name and attribute of each format, as somebody may edit it."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")
_TAG = re.compile(r"<(/?)([\w:]+)((?:\s+[\w:]+=\"[^\"]*\")*)\s*(/?)>|<!--.*?-->|<\?.*?\?>", re.DOTALL)
_ATTRIBUTE = re.compile(r'([\w:]+)="([^"]*)"')
_NAMES = (
    "name",
    "link",
    "joint",
    "joint_name",
    "site",
    "body",
    "geom",
    "body1",
    "body2",
    "link1",
    "link2",
    "tendon",
    "class",
    "relative_to",
)
# What hangs on a joint of a URDF or an SDF, by which its place is told.
_CHILD = re.compile(r'(?:(?!</joint>).)*?(?:<child link="([^"]+)"|<child>([^<]+)<)', re.DOTALL)
# The link that a shape of an SDF belongs to, where another carries it.
_OF_LINK = re.compile(r'(?:(?!</(?:collision|visual)>).)*?<pose relative_to="([^"]+)"', re.DOTALL)
_SHAPES = re.compile(r'<body name="([^"]+)"|<geom [^>]*material="([^"]+)"')
_YAML = re.compile(r"^(\s*(?:- )*)([\w.\-/\"]+): *([^\s#{\[|>].*?)\s*$", re.MULTILINE)
_JSON = re.compile(r'"(\w+)": ("[^"]*"|-?\d[^,}\]\s]*|true|false)')

# A list on one line of a JSON or a YAML, by its key.
_LIST = re.compile(r'(\w+)"?: \[([^\[\]{}\n]+)\]')
_LONGEST = 6  # of its items each is a kind of its own


class Planted(NamedTuple):
    """A change of a text: what was changed, in words that stay, and the whole text with it.

    ``group`` is the kind of place (the path of elements, the attribute, the kind of change); ``named`` are the names
    that stand around the place, the innermost first: one of them has to be told.
    """

    group: tuple[str, ...]
    where: str
    named: tuple[str, ...]
    text: str

    @property
    def kind(self) -> tuple[str, ...]:
        """The kind of place, in however deep a tree."""
        return tuple(word for before, word in zip(("", *self.group), self.group, strict=False) if word != before)


def one_of_each(changes: Sequence[Planted], had: set[tuple[str, ...]], seed: int) -> list[Planted]:
    """Return one change of each kind of place that nobody has had, by a seed; they are had then."""
    kinds: dict[tuple[str, ...], list[Planted]] = {}
    for change in changes:
        kinds.setdefault(change.kind, []).append(change)
    chance = random.Random(seed)  # noqa: S311
    fresh = [chance.choice(some) for kind, some in kinds.items() if kind not in had]
    had.update(kinds)
    return fresh


def planted(text: str, file: str) -> Iterator[Planted]:
    """Yield every change of an artifact."""
    if file.endswith((".urdf", ".xml", ".sdf", ".srdf")):
        yield from _in_xml(text)
    elif file.endswith((".json", ".yaml")):
        yield from _in_keys(text, _JSON if file.endswith(".json") else _YAML)
    elif file.endswith((".py", ".md")):
        yield from _in_words(text)


def drawn(changes: Sequence[Planted], count: int, seed: int) -> list[Planted]:
    """Return as many changes of as many groups as there are, by a seed."""
    chance = random.Random(seed)  # noqa: S311
    groups: dict[tuple[str, ...], list[Planted]] = {}
    for change in changes:
        groups.setdefault(change.group, []).append(change)
    for group in groups.values():
        chance.shuffle(group)
    taken: list[Planted] = []
    while len(taken) < count and any(groups.values()):
        taken += [group.pop() for group in groups.values() if group]
    return sorted(taken[:count], key=lambda one: one.where)


def _in_xml(text: str) -> Iterator[Planted]:
    """Yield the changes of attributes and of the texts of elements."""
    path: list[str] = []
    names: list[list[str]] = []
    for tag in _TAG.finditer(text):
        closing, kind, attributes, alone = tag.groups()
        if kind is None:
            continue
        if closing:
            path.pop()
            names.pop()
            continue
        own = dict(_ATTRIBUTE.findall(attributes))
        here = [own[key] for key in _NAMES if key in own]
        if kind == "joint" and (child := _CHILD.match(text, tag.end())):
            here.append(child[1] or child[2])
        if kind in ("collision", "visual") and (other := _OF_LINK.match(text, tag.end())):
            here.append(other[1])
        if path[-1:] == ["asset"] and kind == "material":
            here += _coloured(text, own.get("name", ""))
        around = tuple(dict.fromkeys([*here, *(name for inner in reversed(names) for name in inner), kind]))
        for found in _ATTRIBUTE.finditer(text, tag.start(3), tag.end(3)):
            place = (*path, kind, found[1])
            yield from _changed(text, found.span(2), place, around)
            yield _cut(text, (found.start() - 1, found.end()), (*place, "removed"), around)
        if not alone:
            path.append(kind)
            names.append(here)
            said = re.compile(r"\s*([^<\s][^<]*?)\s*<").match(text, tag.end())
            if said:
                yield from _changed(text, said.span(1), (*path, "text"), around)


def _coloured(text: str, material: str) -> Iterator[str]:
    """Yield the bodies of an MJCF whose shapes have a material: a colour is told of them."""
    body = ""
    for found in _SHAPES.finditer(text):
        if found[2] == material:
            yield body
        body = found[1] or body


def _in_keys(text: str, pattern: re.Pattern[str]) -> Iterator[Planted]:
    """Yield the changes of the values of a JSON or a YAML; around are the keys and names on the lines before."""
    group = 2 if pattern is _JSON else 3
    for found in pattern.finditer(text):
        key = found[group - 1].strip('"')
        before = text[: found.start()].splitlines()[-12:]
        around = [word for line in reversed(before) for word in re.findall(r"[A-Za-z_]\w+", line)]
        value = found.span(group)
        inner = (value[0] + 1, value[1] - 1) if text[value[0]] in "\"'" else value
        yield from _changed(text, inner, (key,), tuple(dict.fromkeys([text[slice(*inner)], key, *around])))


def planted_in_lists(text: str, file: str) -> Iterator[Planted]:
    """Yield every change of an item of a list of a JSON or a YAML."""
    for found in _LIST.finditer(text) if file.endswith((".json", ".yaml")) else ():
        around = _before(text, found.start())
        for number, item in enumerate(re.finditer(r"[^\s,\"']+(?: [^\s,\"']+)*", found[2])):
            start = found.start(2) + item.start()
            place = (found[1], f"item {min(number, _LONGEST)}")
            yield from _changed(text, (start, start + len(item[0])), place, (item[0], found[1], *around))


def _before(text: str, start: int) -> list[str]:
    """Return the words of the lines before a place, the nearest ones first."""
    before = text[:start].splitlines()[-12:]
    return [word for line in reversed(before) for word in reversed(re.findall(r"[A-Za-z_]\w+", line))]


def _in_words(text: str) -> Iterator[Planted]:
    """Yield the changes of the numbers and frames of a launch file or a table; around are the words of some lines."""
    for found in re.finditer(r"(?<=[\"'`| ])(?:-?\d+\.\d+|[a-z]\w*_(?:link|frame|footprint))(?=[\"'`| ])", text):
        begin = text.rfind("\n", 0, max(0, found.start() - 200)) + 1
        around = re.findall(r"[A-Za-z_]\w+", text[begin : found.end() + 200])
        key = re.sub(r"[^a-z]+", " ", text[text.rfind("\n", 0, found.start()) + 1 : found.start()].lower()).strip()
        yield from _changed(text, found.span(), (key.split(" ")[-1],), tuple(dict.fromkeys([found[0], *around])))


def _changed(text: str, span: tuple[int, int], place: tuple[str, ...], around: tuple[str, ...]) -> Iterator[Planted]:
    """Yield the change of each number of a value, or of the word that it is."""
    value = text[slice(*span)]
    numbers = list(NUMBER.finditer(value)) if NUMBER.sub("", value).strip() == "" else []
    for number, found in enumerate(numbers):
        start, end = span[0] + found.start(), span[0] + found.end()
        new = str(int(found[0]) + 1) if found[0].lstrip("-").isdigit() else f"{float(found[0]) * 1.01 + 0.0123:.6g}"
        where = f"{'/'.join(place)}[{number}] {found[0]} -> {new}"
        yield Planted((*place, f"number {number}"), where, around, text[:start] + new + text[end:])
    if not numbers and value:
        new = {"true": "false", "false": "true"}.get(value, f"{value}_x")
        where = f"{'/'.join(place)} {value} -> {new}"
        yield Planted((*place, "word"), where, around, text[: span[0]] + new + text[span[1] :])


def _cut(text: str, span: tuple[int, int], place: tuple[str, ...], around: tuple[str, ...]) -> Planted:
    where = f"{'/'.join(place)} {text[span[0] + 1 : span[1]]}"
    return Planted(place, where, around, text[: span[0]] + text[span[1] :])
