"""Proving: a translation is compiled for every combination of arguments and held against what xacro makes.

What differs, or cannot be compiled, names the macro at fault: first it gets long names, then it is written out where it
is called. What cannot be said even so leaves the robot flat.
"""

from __future__ import annotations

import itertools
import os
import posixpath
import re
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.compare.proof import Proof, Tolerance
from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.model import Robot
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Span
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Document

from ..read_back import by_elements, read_back, without_words
from .differing_elements import called, shortened
from .flattened import Place, outermost, place_of
from .scopes import FLAG, LIST, NAME, NUMBER, WORDS, XML, Variable, literal

MAX_COMBINATIONS = 32
PROBE = "probe_"  # what an argument is given beside its default that stands in names
_AS_URDF = Proof.model(Tolerance.NUMBER, carried_by_urdf=True)

Combination = tuple[tuple[str, str], ...]


class Fault(NamedTuple):
    """What is wrong with a translation: a sentence, the macros that may be at fault, and with which arguments.

    ``refused``: it cannot be compiled, or not read back; else it is another robot.
    """

    text: str
    macros: tuple[str, ...]
    combination: Combination
    tops: tuple[Place, ...] = ()
    refused: bool = False
    own: tuple[Place, ...] = ()  # the elements themselves, where the fault names them


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
            with _environment(variables):
                arguments = {**self.options.arguments, **rest}
                read = read_robot(self.path, replace(self.options, arguments=arguments))
            if self.meshes is not None and read.tree is not None:
                read = read.with_files_below(self.meshes)
            self.known[combination] = read
        return self.known[combination]


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    """Have variables in the environment for a while."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, text in before.items():
            if text is None:
                del os.environ[name]
            else:
                os.environ[name] = text


def choices_of(arguments: Mapping[str, Variable], given: Mapping[str, str]) -> dict[str, list[str]]:
    """Return the values that each argument may have, as far as the source compares it: the default first.

    That is what is given, where anything is; what the source says for it comes next.
    """
    made: dict[str, list[str]] = {}
    for name, variable in arguments.items():
        defaults = [given.get(name), variable.values[0].text if variable.values else None]
        values = list(dict.fromkeys(one for one in defaults if one is not None and "$" not in one))
        compared = sorted(one[1:] for one in variable.head().evidence if one.startswith("="))
        kind, said = variable.kind(), len(values)
        if kind == FLAG:
            values = values[: 1 if len({value.lower() for value in values}) == 1 else None]
            values += [one for one in ("true", "false") if one not in [value.lower() for value in values]]
        elif kind == NUMBER and "condition" in variable.head().evidence:
            values += [one for one in ("0", "1") if one not in values]
        elif kind == NUMBER:
            values += [one for one in compared if one not in values and isinstance(literal(one), (int, float))]
        elif kind in (WORDS, "any"):
            values += [one for one in compared if one not in values]
            names = NAME in variable.head().evidence and 0 < len(values) == said
            if names or (compared and len(values) == 1):  # what holds for none of the texts that it is compared with
                values.append(PROBE)
        made[name] = values
    return made


def other_values(arguments: Mapping[str, Variable], given: Mapping[str, str]) -> dict[str, str]:
    """Return another number or text for each argument that may be any, by name: whether those are followed is asked."""
    made: dict[str, str] = {}
    for name, variable in arguments.items():
        text = given.get(name, variable.values[0].text if variable.values else "$")
        if "$" in text or any(one.startswith("=") for one in variable.head().evidence):
            continue
        value = literal(text)
        if variable.kind() == NUMBER and isinstance(value, (int, float)):
            made[name] = repr(value + 1 if isinstance(value, int) else value * 1.25 + 0.01)
        elif variable.kind() == LIST and isinstance(value, list):
            made[name] = " ".join(repr(one * 1.25 + 0.01) for one in value)
        elif not variable.used and text.lower() in ("true", "false"):
            made[name] = "false" if text.lower() == "true" else "true"
        elif variable.kind() == WORDS and XML in variable.head().evidence and NAME not in variable.head().evidence:
            made[name] = f"{text}{PROBE}"
    return made


def moves(source: Source, row: Combination) -> bool:
    """Say whether xacro makes another robot of a combination of arguments than without it."""
    known = row in source.known
    base, other = source.read(()), source.read(row)
    if not known:
        source.known.pop(row)  # nobody asks for it
    one, two = base.robot, other.robot
    if one is None or two is None:
        return False
    return bool(Proof.of(_settled(one), _settled(two), _AS_URDF).texts)


def combinations(choices: Mapping[str, Sequence[str]]) -> tuple[list[Combination], int]:
    """Return the combinations that are proven, that of the defaults first, and how many there would be."""
    several = {name: values for name, values in choices.items() if len(values) > 1}
    total = 1
    for values in several.values():
        total *= len(values)
    if total <= MAX_COMBINATIONS:
        rows = itertools.product(*several.values())
        return [_combination(several, row) for row in rows], total
    first = tuple(values[0] for values in several.values())
    found = [first]
    for index, values in enumerate(several.values()):
        found += [(*first[:index], value, *first[index + 1 :]) for value in values[1:]]
    last = tuple(values[-1] for values in several.values())
    found.append(last)
    found = list(dict.fromkeys(found))[:MAX_COMBINATIONS]
    return [_combination(several, row) for row in found], total


def _combination(several: Mapping[str, Sequence[str]], row: Sequence[str]) -> Combination:
    return tuple(
        (name, value) for (name, values), value in zip(several.items(), row, strict=True) if value != values[0]
    )


def faults(
    files: Mapping[str, str],
    source: Source,
    rows: Sequence[Combination],
    packages: Mapping[str, Path],
    elements: Mapping[tuple[str, str, str], Place],
    in_words: bool = False,
) -> tuple[list[Fault], list[Combination]]:
    """Return what is wrong with a translation, and the combinations that xacro itself refuses.

    ``in_words`` holds its elements against those of the source by what they mean, as the flat import does.
    """
    refused: list[Combination] = []
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        stage = Path(name, Description.FOLDER, "robot")  # files of other robots are beside
        stage.mkdir(parents=True)
        for file, text in files.items():
            (stage / file).parent.mkdir(parents=True, exist_ok=True)
            (stage / file).write_text(text, "utf-8")
        for number, row in enumerate(rows):
            Progress.step("proving the translation", number, len(rows))
            made = source.read(row)
            if made.tree is None or any(one.severity == ERROR for one in made.diagnostics):
                if all(value != PROBE for _, value in row):
                    refused.append(row)
                continue
            found = _faults(stage, files, made, row, packages, elements, source.name, in_words)
            if found:
                return found, refused
    return [], refused


def _faults(
    stage: Path,
    files: Mapping[str, str],
    made: Imported,
    row: Combination,
    packages: Mapping[str, Path],
    elements: Mapping[tuple[str, str, str], Place],
    name: str | None,
    in_words: bool,
) -> list[Fault]:
    compiled = compile_robot(stage / Description.ROOT_FILE, dict(row), packages=dict(packages), exact=True)
    errors = [one for one in compiled.diagnostics if one.severity == ERROR]
    if errors or compiled.robot is None:
        return [
            Fault(
                _told(one, stage),
                _parts_at(one, stage, files),
                row,
                _elements_at(one, stage, files, elements),
                refused=True,
            )
            for one in errors[:5]
        ]
    back = read_back(stage, {one.backend: one.text for one in compiled.artifacts}, made.whole)
    source, again = made.robot, back.robot
    if source is None or again is None:
        broken = [one.message for one in back.diagnostics if one.severity == ERROR]
        return [Fault(f"what is compiled cannot be read back: {' '.join(broken[:1])}", (), row, refused=True)]
    if name is not None:
        source = replace(source, name=name)
    found = by_elements(source, again, compiled.robot.asks_for_humble) if in_words else []
    again = without_words(again, source) if in_words else again
    source, again = _settled(source), _settled(again)
    found = [*found, *Proof.of(source, again, _AS_URDF).texts][:8]
    entries = _entries_of(made)
    return [
        _fault(told, row, [*_spans_in(one, entries), *_spans_called(told, made)])
        for one, told in zip(found, shortened(found, source, again), strict=True)
    ]


def _fault(told: str, row: Combination, spans: list[Span]) -> Fault:
    """Return a fault of what stands at some places of the source: the innermost macros first."""
    via = [one.message for span in spans for one in getattr(span, "via", ())]
    macros = dict.fromkeys(re.findall(r'the macro "([^"]+)"', " ".join(via)))
    tops, own = (tuple(dict.fromkeys(map(place, spans))) for place in (outermost, place_of))
    return Fault(told, tuple(macros), row, tops, own=own)


def _told(diagnostic: Diagnostic, stage: Path) -> str:
    """Return what an error says, with files as the description calls them: where they stand now is gone soon."""
    span = diagnostic.span
    where = f" ({Path(span.source.path).name}:{span.line})" if span else ""
    said = diagnostic.message.replace(f"{stage}/", "").replace(f"{files.resolve(stage)}/", "")
    return f"{said}{where}"


def _parts_at(diagnostic: Diagnostic, stage: Path, files: Mapping[str, str]) -> tuple[str, ...]:
    """Return the parts and named values that an error stands in, or that led to it."""
    spans: list[Span | None] = [diagnostic.span, *(related.span for related in diagnostic.related)]
    found: list[str] = []
    for span in spans:
        if span is None:
            continue
        name = _name_of(span, stage)
        if name in files:
            found += _part_at(files[name], span.line)
    found += re.findall(r'part "(\w+)"', " ".join(related.message for related in diagnostic.related))
    return tuple(dict.fromkeys(found))


def _name_of(span: Span, stage: Path) -> str:
    """Return the name of the file of a span as seen from the folder of the robot."""
    return Path(os.path.relpath(files.resolve(span.source.path), files.resolve(stage))).as_posix()


def _elements_at(
    diagnostic: Diagnostic, stage: Path, files: Mapping[str, str], elements: Mapping[tuple[str, str, str], Place]
) -> tuple[Place, ...]:
    """Return the elements at the top of the source that the entries come from that an error stands in."""
    from rosorin_compile.source.diagnostics import Source as Text

    found: list[Place] = []
    for span in (diagnostic.span, *(related.span for related in diagnostic.related)):
        if span is None:
            continue
        try:
            name = _name_of(span, stage)
            tree = parse_yaml(Text("", files[name]))
        except (ValueError, KeyError, LoadError):
            continue
        for section in ("links", "joints", "use"):
            entries = tree.get(section)
            lines = [(entries.key_spans[key].line, key) for key in entries] if isinstance(entries, Map) else []
            after = [tree.key_spans[key].line for key in tree if lines and tree.key_spans[key].line > lines[0][0]]
            keys = [key for line, key in lines if line <= span.line < min(after, default=10**9)]
            if keys and (name, section, keys[-1]) in elements:
                found.append(elements[name, section, keys[-1]])
    return tuple(dict.fromkeys(found))


def _part_at(text: str, line: int) -> list[str]:
    from rosorin_compile.source.diagnostics import Source as Text

    try:
        tree = parse_yaml(Text("", text))
    except LoadError:
        return []
    for section in ("parts", "let"):
        entries = tree.get(section)
        if not isinstance(entries, Map):
            continue
        lines = [(entries.key_spans[name].line, name) for name in entries]
        after = [tree.key_spans[key].line for key in tree if tree.key_spans[key].line > tree.key_spans[section].line]
        if not (tree.key_spans[section].line <= line < min(after, default=10**9)):
            continue
        names = [name for start, name in lines if start <= line]
        return [names[-1].partition("(")[0]] if names else []
    return []


def _entries_of(made: Imported) -> dict[str, list[Span]]:
    """Return where each link and joint was made."""
    found: dict[str, list[Span]] = {}
    for section in ("links", "joints"):
        entries: Any = made.tree.get(section) if made.tree is not None else None
        for name in entries or ():
            found.setdefault(name, []).append(entries.value_spans[name])
    return found


def _spans_in(text: str, entries: Mapping[str, list[Span]]) -> list[Span]:
    """Return where the links and joints were made that a sentence names."""
    words = _words(text)
    return [span for name, spans in entries.items() if name in words for span in spans]


def _spans_called(told: str, made: Imported) -> list[Span]:
    """Return where the elements were made that a sentence is about."""
    elements: Any = made.tree.get("urdf_elements") if made.tree is not None else None
    if not told.startswith("<") or elements is None:
        return []
    pairs = zip(elements, elements.value_spans, strict=True)
    return [span for text, span in pairs if told.startswith(f"{called(Document.tree(str(text)))}: ")]


def _words(text: str) -> set[str]:
    return set(re.findall(r"[\w./-]+", text))


def _settled(robot: Robot) -> Robot:
    """Return a robot whose elements of XML are in one spelling and order."""
    return _replaced(robot)  # type: ignore[no-any-return]


def _replaced(value: Any) -> Any:
    from dataclasses import fields, is_dataclass

    if not is_dataclass(value) or isinstance(value, type):
        return value
    changes: dict[str, Any] = {}
    for field in fields(value):
        inner = getattr(value, field.name)
        if field.name == "urdf_elements":
            changes[field.name] = tuple(sorted(_canonical(one) for one in inner))
        elif field.name == "geometry" and "/../" in str(getattr(inner, "file", "")):
            scheme, sign, rest = inner.file.partition("://")
            changes[field.name] = replace(
                inner, file=f"{scheme}{sign}{posixpath.normpath(rest)}" if sign else inner.file
            )
        elif field.name in ("links", "joints", "visual", "collision") and isinstance(inner, tuple):
            changes[field.name] = tuple(_replaced(one) for one in inner)
    return replace(value, **changes) if changes else value


def _canonical(text: str) -> str:
    try:
        return Document.canonical(Document.tree(text))
    except ValueError:
        return " ".join(text.split())
