"""Verify a translation: compile it for combinations of arguments and compare it with what xacro makes."""

from __future__ import annotations

import itertools
import math
import os
import posixpath
import re
import tempfile
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.language.expand.included_robots import move_files
from rosorin_compile.model import Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Span
from rosorin_compile.source.diagnostics import Source as Text
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.elements import canonical, tree_of

from ..same_model import by_elements, model_differences, read_back, without_words
from .documents import PROBE

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COMBINATIONS = 16

Combination = tuple[tuple[str, str], ...]


class Fault(NamedTuple):
    """What is wrong with a translation, the macros that may be at fault, and with which arguments.

    ``refused``: it cannot be compiled, or not read back; otherwise it is another robot.
    """

    text: str
    macros: tuple[str, ...]
    combination: Combination
    refused: bool = False


class Source:
    """What xacro makes, by combination of arguments; each is expanded once."""

    def __init__(self, path: Path, options: ReadOptions, name: str | None = None, meshes: str | None = None) -> None:
        self.path = path
        self.name = name
        self.meshes = meshes
        self.options = replace(options, trust=True, tell=None)
        self.known: dict[Combination, Imported] = {}
        self.environment: Collection[str] = ()

    def read(self, combination: Combination) -> Imported:
        """Return the robot for a combination of arguments."""
        if combination not in self.known:
            variables = {name: text for name, text in combination if name in self.environment}
            rest = {name: text for name, text in combination if name not in variables}
            options = replace(self.options, arguments={**self.options.arguments, **rest})
            if variables:
                options = replace(options, environment={**(options.environment or os.environ), **variables})
            read = read_robot(self.path, options)
            if self.meshes is not None and read.tree is not None:
                read = read._replace(tree=move_files(read.tree, self.meshes))
            self.known[combination] = read
        return self.known[combination]


def moves(source: Source, row: Combination) -> bool:
    """Return True if xacro makes another robot with a combination of arguments than without it."""
    known = row in source.known
    base, other = source.read(()).robot, source.read(row).robot
    if not known:
        source.known.pop(row)
    if base is None or other is None:
        return False
    return bool(model_differences(_settled(base), _settled(other), carried_by_urdf=True))


def combinations(choices: Mapping[str, Sequence[str]]) -> tuple[list[Combination], int]:
    """Return the combinations that are proven, that of the defaults first, and how many there would be."""
    several = {name: values for name, values in choices.items() if len(values) > 1}
    total = math.prod(map(len, several.values()))
    rows: list[dict[str, str]] = (
        [dict(zip(several, row, strict=True)) for row in itertools.product(*several.values())]
        if (total <= MAX_COMBINATIONS)
        else [{}, *({name: value} for name, values in several.items() for value in values[1:])]
    )
    if total > MAX_COMBINATIONS:
        rows.append({name: values[-1] for name, values in several.items()})
    made = [tuple((name, value) for name, value in row.items() if value != several[name][0]) for row in rows]
    return list(dict.fromkeys(made))[:MAX_COMBINATIONS], total


def faults(
    files: Mapping[str, str],
    source: Source,
    rows: Sequence[Combination],
    packages: Mapping[str, Path],
    in_words: bool = False,
    is_late: Callable[[], bool] = lambda: False,
) -> tuple[list[Fault], list[Combination], list[Combination]]:
    """Return what is wrong with a translation, the combinations that were compared, and those that xacro refuses.

    The first two are always compared, the others unless it ``is_late``.
    ``in_words`` compares elements by what they mean.
    """
    compared: list[Combination] = []
    refused: list[Combination] = []
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        stage = Path(name, Description.FOLDER, "robot")  # files of other robots are next to it
        for file, text in files.items():
            (stage / file).parent.mkdir(parents=True, exist_ok=True)
            (stage / file).write_text(text, "utf-8")
        for number, row in enumerate(rows):
            if number > 1 and is_late():
                break
            Progress.step("proving the translation", number, len(rows))
            made = source.read(row)
            if made.tree is None or any(one.severity == ERROR for one in made.diagnostics):
                if all(value != PROBE for _, value in row):
                    refused.append(row)
                continue
            compiled = compile_robot(stage / Description.ROOT_FILE, dict(row), packages=dict(packages), exact=True)
            errors = [one for one in compiled.diagnostics if one.severity == ERROR]
            if errors or compiled.robot is None:
                entries = _Entries(stage, files)
                return [entries.fault(one, row) for one in errors[:5]], compared, refused
            found = _differences(stage, compiled, made, row, source.name, in_words)
            if found:
                return found, compared, refused
            compared.append(row)
    return [], compared, refused


def _differences(
    stage: Path, compiled: Any, made: Imported, row: Combination, name: str | None, in_words: bool
) -> list[Fault]:
    """Return what differs between the compiled robot and that of xacro."""
    back = read_back(stage, {one.backend: one.text for one in compiled.artifacts}, made.whole)
    source, again = made.robot, back.robot
    if source is None or again is None:
        broken = [one.message for one in back.diagnostics if one.severity == ERROR]
        return [Fault(f"what is compiled cannot be read back: {' '.join(broken[:1])}", (), row, refused=True)]
    if name is not None:
        source = replace(source, name=name)
    texts = by_elements(source, again, compiled.robot) if in_words else []
    again = without_words(again, source) if in_words else again
    source, again = _settled(source), _settled(again)
    texts += model_differences(source, again, carried_by_urdf=True)
    differing = list(_differing_elements(source, again))
    found: list[Fault] = []
    for text in texts[:8]:
        if differing and " element " in text:
            text = differing.pop(0) if len(differing) > 1 else differing[0]
        spans = list(_spans(text, made))
        via = " ".join(one.message for span in spans for one in getattr(span, "via", ()))
        macros = tuple(dict.fromkeys(re.findall(r'the macro "([^"]+)"', via)))
        found.append(Fault(_cut(text, 200), macros, row))
    return found


def _spans(text: str, made: Imported) -> Iterator[Span]:
    """Yield the places of the links, joints and elements that a sentence names."""
    names = set(re.findall(r"[\w./-]+", text))
    for section in ("links", "joints"):
        entries: Any = made.whole.get(section) or {}
        yield from (entries.value_spans[name] for name in entries if name in names)
    elements: Any = made.whole.get("urdf_elements")
    if text.startswith("<") and elements is not None:
        for element, span in zip(elements, elements.value_spans, strict=True):
            if text.startswith(f"{_called(tree_of(str(element)))}: "):
                yield span


class _Entries:
    """The entries of a description by their lines: where an error is, in terms of the xacro."""

    def __init__(self, stage: Path, texts: Mapping[str, str]) -> None:
        self.stage = files.resolve(stage)
        self.trees: dict[str, Map] = {}
        for name, text in texts.items():
            with suppress(LoadError):
                self.trees[name] = parse_yaml(Text("", text))

    def fault(self, diagnostic: Diagnostic, row: Combination) -> Fault:
        """Return an error of the compiler as a fault of the translation."""
        span = diagnostic.span
        where = f" ({Path(span.source.path).name}:{span.line})" if span else ""
        macros: list[str] = []
        for one in (span, *(related.span for related in diagnostic.related)):
            file = os.path.relpath(files.resolve(one.source.path), self.stage) if one is not None else ""
            for section, key in self._at(file, one.line) if one is not None else ():
                if section in ("parts", "let"):
                    macros.append(key.partition("(")[0])
        macros += re.findall(r'part "(\w+)"', " ".join(related.message for related in diagnostic.related))
        text = diagnostic.message.replace(f"{self.stage}/", "")
        return Fault(f"{text}{where}", tuple(dict.fromkeys(macros)), row, refused=True)

    def _at(self, file: str, line: int) -> Iterator[tuple[str, str]]:
        """Yield the section and the key of the entry at a line."""
        tree = self.trees.get(file)
        before = [key for key in tree if tree.key_spans[key].line <= line] if isinstance(tree, Map) else []
        entries = tree[before[-1]] if tree is not None and before else None
        keys = [key for key in entries if entries.key_spans[key].line <= line] if isinstance(entries, Map) else []
        if keys:
            yield before[-1], keys[-1]


def _settled(value: Any) -> Any:
    """Return a robot with its elements of XML, and the names of its meshes, in one spelling."""
    if not is_dataclass(value) or isinstance(value, type):
        return value
    changes: dict[str, Any] = {}
    for field in fields(value):
        inner = getattr(value, field.name)
        if field.name == "urdf_elements":
            changes[field.name] = tuple(sorted(_canonical(one) for one in inner))
        elif field.name == "geometry" and "/../" in str(getattr(inner, "file", "")):
            scheme, sign, rest = inner.file.partition("://")
            file = f"{scheme}{sign}{posixpath.normpath(rest)}" if sign else inner.file
            changes[field.name] = replace(inner, file=file)
        elif field.name in ("links", "joints", "visual", "collision") and isinstance(inner, tuple):
            changes[field.name] = tuple(map(_settled, inner))
    return replace(value, **changes) if changes else value


def _canonical(text: str) -> str:
    try:
        return canonical(tree_of(text))
    except ValueError:
        return " ".join(text.split())


def _differing_elements(source: Robot, again: Robot) -> Iterator[str]:
    """Yield a sentence for each element of XML that only one of two robots has."""
    pairs = [("", source.urdf_elements, again.urdf_elements)]
    for section in ("links", "joints"):
        others = {one.name: one for one in getattr(again, section)}
        for one in (one for one in getattr(source, section) if one.name in others):
            pairs.append((f'{section[:-1]} "{one.name}": ', one.urdf_elements, others[one.name].urdf_elements))
    for where, mine, theirs in pairs:
        lost = {_called(tree_of(text)) for text in (Counter(mine) - Counter(theirs)).elements()}
        new = {_called(tree_of(text)) for text in (Counter(theirs) - Counter(mine)).elements() if text[:1] == "<"}
        yield from (f"{where}{name}: it is different" for name in sorted(lost & new))
        yield from (f"{where}{name}: only xacro makes it" for name in sorted(lost - new))
        yield from (f"{where}{name}: only the translation makes it" for name in sorted(new - lost))


def _called(element: Element) -> str:
    """Return the start tag of an element with its name."""
    key = "name" if element.get("name") else "reference"
    return f'<{element.tag} {key}="{element.get(key)}">' if element.get(key) else f"<{element.tag}>"


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 3].rstrip()}..."
