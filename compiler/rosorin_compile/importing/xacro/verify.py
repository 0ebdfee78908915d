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
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.language.expand.included_robots import move_files
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import ERROR, Diagnostic
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.xml.elements import canonical, tree_of

from ..round_trip import model_differences

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COMBINATIONS = 16

Combination = tuple[tuple[str, str], ...]


class Fault(NamedTuple):
    """What is wrong with a translation, the macros that may be at fault, and with which arguments."""

    text: str
    macros: tuple[str, ...]
    combination: Combination


class Source:
    """What xacro makes, by combination of arguments; each is expanded once."""

    def __init__(self, path: Path, options: ReadOptions, name: str | None = None, meshes: str | None = None) -> None:
        self.path, self.name, self.meshes = path, name, meshes
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


def combinations(choices: Mapping[str, Sequence[str]]) -> tuple[list[Combination], int]:
    """Return the combinations that are compared, that of the defaults first, and how many there would be."""
    several = {name: values for name, values in choices.items() if len(values) > 1}
    total = math.prod(map(len, several.values()))
    if total <= MAX_COMBINATIONS:
        rows = [dict(zip(several, row, strict=True)) for row in itertools.product(*several.values())]
    else:
        rows = [{}, *({name: value} for name, values in several.items() for value in values[1:])]
    made = [tuple((name, value) for name, value in row.items() if value != several[name][0]) for row in rows]
    return list(dict.fromkeys(made)), total


class Comparison(NamedTuple):
    """What is wrong with a translation, the combinations that were compared, and those that xacro refuses."""

    faults: list[Fault]
    compared: list[Combination]
    refused: list[Combination]


def compare(
    files: Mapping[str, str],
    source: Source,
    rows: Sequence[Combination],
    packages: Mapping[str, Path],
    is_late: Callable[[], bool] = lambda: False,
) -> Comparison:
    """Compare a translation with the source, up to the first combination that differs.

    The first two are always compared, the others unless it ``is_late``.
    """
    compared: list[Combination] = []
    refused: list[Combination] = []
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        stage = Path(name, Description.FOLDER, "robot")  # other descriptions are next to it
        for file, text in files.items():
            (stage / file).parent.mkdir(parents=True, exist_ok=True)
            (stage / file).write_text(text, "utf-8")
        for number, row in enumerate(rows):
            if number > 1 and is_late():
                break
            Progress.step("proving the translation", number, len(rows))
            made = source.read(row)
            if made.tree is None or any(one.severity == ERROR for one in made.diagnostics):
                refused.append(row)
                continue
            compiled = compile_robot(stage / Description.ROOT_FILE, dict(row), packages=dict(packages), exact=True)
            errors = [one for one in compiled.diagnostics if one.severity == ERROR]
            if errors or compiled.robot is None:
                return Comparison([_error(one, stage, row) for one in errors[:5]], compared, refused)
            found = _differences(compiled, made, row, source.name)
            if found:
                return Comparison(found, compared, refused)
            compared.append(row)
    return Comparison([], compared, refused)


def _error(diagnostic: Diagnostic, stage: Path, row: Combination) -> Fault:
    """Return an error of the compiler as a fault of the translation: of the parts and named values that it is in."""
    span = diagnostic.span
    where = f" ({Path(span.source.path).name}:{span.line})" if span else ""
    macros = re.findall(r'part "(\w+)"', " ".join(related.message for related in diagnostic.related))
    for one in (span, *(related.span for related in diagnostic.related)):
        if one is None:
            continue
        section = entry = ""
        for line in one.source.text.splitlines()[: one.line]:
            if match := re.match(r"(  )?([\w.-]+)[(:]", line):
                section, entry = (section, match[2]) if match[1] else (match[2], "")
        macros += [entry] if section in ("parts", "let") and entry else []
    return Fault(diagnostic.message.replace(f"{stage}/", "") + where, tuple(dict.fromkeys(macros)), row)


def _differences(compiled: Any, made: Imported, row: Combination, name: str | None) -> list[Fault]:
    """Return what differs between the compiled robot and that of xacro."""
    source, again = made.robot, compiled.robot
    if source is None or again is None:
        return [Fault("what is compiled is no robot", (), row)]
    if name is not None:
        source = replace(source, name=name)
    source, again = _settled(source), _settled(again)
    texts = [one for one in model_differences(source, again) if " element " not in one]
    texts += _differing_elements(source, again)
    return [Fault(text[:200], tuple(_macros(text, made)), row) for text in texts[:8]]


def _macros(text: str, made: Imported) -> Iterator[str]:
    """Yield the macros that made the links, joints and elements that a sentence names."""
    names = set(re.findall(r"[\w./-]+", text))
    spans = []
    for section in ("links", "joints"):
        entries: Any = made.whole.get(section) or {}
        spans += [entries.value_spans[name] for name in entries if name in names]
    elements: Any = made.whole.get("urdf_elements")
    if text.startswith("<") and elements is not None:
        pairs = zip(elements, elements.value_spans, strict=True)
        spans += [span for element, span in pairs if text.startswith(f"{_called(tree_of(str(element)))}: ")]
    for span in spans:
        for one in getattr(span, "via", ()):
            yield from re.findall(r'the macro "([^"]+)"', one.message)


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
        others = {one.name: one.urdf_elements for one in getattr(again, section)}
        for one in getattr(source, section):
            pairs.append((f'{section[:-1]} "{one.name}": ', one.urdf_elements, others.get(one.name, ())))
    for where, mine, theirs in pairs:
        for text in ((Counter(mine) - Counter(theirs)) + (Counter(theirs) - Counter(mine))).elements():
            yield f"{where}{_called(tree_of(text)) if text[:1] == '<' else text[:60]}: it is different"


def _called(element: Element) -> str:
    """Return the start tag of an element with its name."""
    key = "name" if element.get("name") else "reference"
    return f'<{element.tag} {key}="{element.get(key)}">' if element.get(key) else f"<{element.tag}>"
