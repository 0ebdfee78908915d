"""``sweep.json``: what a sweep says of its variants, a line each, read one by one."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from io import TextIOWrapper
from pathlib import Path, PurePosixPath
from typing import Any, NamedTuple

from rosorin_compile.diagnostics import Diagnostic, Heading, Rule, Source, Span, error, printable
from rosorin_compile.extending import WrongUsage, world

RULES = (
    Rule(
        "fleet-file",
        "The file is not what a sweep writes, or not all of it.",
        "Run the sweep again: it does only what is missing.",
        Heading.FLEETS,
    ),
)

MADE = "made"
_KIND = "sweep"
_VERSION = 1
_MAX_LINE = 16_000_000  # letters; a variant has some thousands
_MAX_WHOLE = 100_000_000  # bytes of a file that is laid out otherwise, and is read at once
_DIGEST = re.compile(r"[0-9a-f]{64}")
_HELP = "run rosorin-compile sweep again: it does only what is missing"


class Variant(NamedTuple):
    """One robot of a sweep: its name, its folder, its arguments, and the artifacts with their SHA-256.

    ``line`` is the text that says so and ``number`` its number, from 1.
    """

    name: str
    folder: Path
    arguments: Mapping[str, Any]
    status: str
    artifacts: Mapping[str, str]
    diagnostics: tuple[Mapping[str, Any], ...]
    file: str
    line: str
    number: int

    @property
    def made(self) -> bool:
        """Whether its artifacts were written."""
        return self.status == MADE

    def span(self, key: str = "name") -> Span:
        """Return where an argument or another key stands; the name of the variant where it does not."""
        for word in (key.split(".")[0].split("[")[0], "name"):
            found = re.search(re.escape(json.dumps(word)) + r"\s*:\s*", self.line) or re.search(
                re.escape(json.dumps(word, ensure_ascii=False)) + r"\s*:\s*", self.line
            )
            if found:
                rest = self.line[found.end() :]
                value = re.match(r'"(?:[^"\\]|\\.)*"|[^,}\]]+', rest)
                length = len(value[0].rstrip()) if value else 1
                return span_of(self.file, self.line, self.number, found.end() + 1, length)
        return span_of(self.file, self.line, self.number, 1)


def span_of(file: str, line: str, number: int, column: int, length: int = 1) -> Span:
    """Return a place in a line of a file that is not kept as a whole."""
    return Span(Source(file, "\n" * (number - 1) + line), number, column, length)


class Head(NamedTuple):
    """What a sweep says beside its variants: the description as it was named, and the arguments of all of them."""

    description: str
    arguments: Mapping[str, Any]


class SweepFile:
    """The variants of a ``sweep.json``. Raises WrongUsage where there is none; ``problem`` is what is wrong in it."""

    def __init__(self, path: Path) -> None:
        self.path = path / "sweep.json" if world.kind(path) == world.FOLDER else path
        self.problem: Diagnostic | None = None
        self.head = Head("", {})
        if world.kind(self.path) != world.FILE:
            way = "rosorin-compile sweep -o FOLDER writes FOLDER/sweep.json"
            raise WrongUsage(f'there is no file "{self.path}"; {way}')
        self.size = world.size(self.path)

    def variants(self) -> Iterator[Variant]:
        """Yield the variants, in their order; ``problem`` is set where the file ends early, or is something else."""
        try:
            try:
                yield from self._by_line()
            except _NotByLine as problem:
                if problem.begun or self.size > _MAX_WHOLE:
                    self._wrong(*problem.place)
                    return
                yield from self._whole()
        except (OSError, UnicodeDecodeError) as problem:
            reason = getattr(problem, "strerror", None) or "it is no UTF-8"
            self.problem = error("fleet-file", f"{self.path} cannot be read: {reason}", None)

    def _by_line(self) -> Iterator[Variant]:
        begun = ended = False
        number, line = 0, ""
        with TextIOWrapper(world.stream(self.path), encoding="utf-8") as file:
            for number, line in enumerate(iter(lambda: file.readline(_MAX_LINE), ""), 1):
                text = line.strip()
                if not begun:
                    self.head = self._headed(text, line, number)
                    begun = True
                elif text in ("]}", "]", "}"):
                    ended = ended or text.endswith("}")
                elif text and ended:
                    raise _NotByLine(True, "there is something after the end", line, number, 1)
                elif text:
                    yield self._variant(_object(text.removesuffix(","), line, number), line, number)
        if not ended:
            where = "is empty" if not begun else f"ends in the middle, after {max(number - 1, 0):,} variants"
            raise _NotByLine(begun, f"{where}: it is not all of a sweep", line, max(number, 1), 1)

    def _headed(self, text: str, line: str, number: int) -> Head:
        """Return what the first line says, which leaves the list of variants open."""
        if not text.startswith("{") or not text.endswith("["):
            raise _NotByLine(False, "", line, number, 1)
        try:
            said = Source(str(self.path), f"{text}]}}").json()
        except ValueError:
            raise _NotByLine(False, "", line, number, 1) from None
        return _head(said, line, number)

    def _whole(self) -> Iterator[Variant]:
        """Yield the variants of a file that another program has laid out otherwise."""
        text = world.text(self.path)
        try:
            said = Source(str(self.path), text).json()
        except ValueError as problem:
            line, column = getattr(problem, "lineno", 1), getattr(problem, "colno", 1)
            lines = text.splitlines() or [""]
            cut = not text.strip() or line >= len(lines)
            reason = "is no JSON, or ends in the middle" if cut else "is no JSON"
            self._wrong(f"{reason}: {getattr(problem, 'msg', problem)}", lines[min(line, len(lines)) - 1], line, column)
            return
        lines = text.splitlines() or [""]
        try:
            self.head = _head(said, lines[0], 1)
            if not isinstance(said.get("variants"), list):
                raise _NotByLine(True, "has no list of variants", lines[0], 1, 1)
            for index, one in enumerate(said["variants"]):
                number = next((at for at, line in enumerate(lines, 1) if json.dumps(_name(one, index)) in line), 1)
                yield self._variant(one, lines[number - 1], number)
        except _NotByLine as problem:
            self._wrong(*problem.place)

    def _variant(self, said: Any, line: str, number: int) -> Variant:
        def fail(what: str) -> _NotByLine:
            return _NotByLine(True, f"has a variant {what}", line, number, 1)

        if not isinstance(said, dict) or not isinstance(said.get("name"), str) or not said["name"]:
            raise fail("without a name")
        name = said["name"]
        folder = said.get("folder", name)
        if not isinstance(folder, str) or "\0" in folder:
            raise fail(f'"{printable(name)}" whose folder is no text')
        arguments, artifacts = said.get("arguments", {}), said.get("artifacts", {})
        if not isinstance(arguments, dict):
            raise fail(f'"{printable(name)}" whose arguments are no names with values')
        if not isinstance(artifacts, dict) or not all(
            isinstance(digest, str) and _DIGEST.fullmatch(digest) for digest in artifacts.values()
        ):
            raise fail(f'"{printable(name)}" whose artifacts are no names with SHA-256 sums')
        if not all(map(_is_inside, artifacts)):
            raise fail(f'"{printable(name)}" with an artifact outside of its folder')
        told = said.get("diagnostics", [])
        if not isinstance(told, list) or not all(isinstance(one, dict) for one in told):
            raise fail(f'"{printable(name)}" whose diagnostics are no list')
        where = self.path.parent / folder
        status = str(said.get("status", MADE))
        return Variant(name, where, arguments, status, artifacts, tuple(told), str(self.path), line, number)

    def _wrong(self, message: str, line: str = "", number: int = 1, column: int = 1) -> None:
        span = span_of(str(self.path), line.rstrip("\n"), number, column)
        self.problem = error("fleet-file", f"{self.path} {message or 'is no JSON of a sweep'}", span, _HELP)


def _is_inside(name: str) -> bool:
    """Say whether the name of an artifact leads nowhere else than below its folder."""
    path = PurePosixPath(name)
    return bool(name) and "\0" not in name and not path.is_absolute() and ".." not in path.parts


class _NotByLine(Exception):
    """A file has not a variant a line; ``begun`` says that it was one of a sweep up to there."""

    def __init__(self, begun: bool, message: str, line: str, number: int, column: int) -> None:
        super().__init__(message)
        self.begun = begun
        self.place = (message, line, number, column)


def _name(said: Any, index: int) -> str:
    return str(said.get("name", index)) if isinstance(said, dict) else str(index)


def _object(text: str, line: str, number: int) -> Any:
    try:
        return Source("", text).json()
    except ValueError as problem:
        reason = getattr(problem, "msg", problem)
        message = f"ends in the middle, after {number - 2:,} variants, or is damaged: {reason}"
        raise _NotByLine(True, message, line, number, getattr(problem, "colno", 1)) from None


def _head(said: Any, line: str, number: int) -> Head:
    """Return what stands beside the variants. Raises _NotByLine if this is no sweep, or one of another version."""
    version = said.get(_KIND) if isinstance(said, dict) else None
    if version is None or isinstance(version, bool):
        raise _NotByLine(True, 'is JSON, but no sweep: it has no "sweep": 1', line, number, 1)
    if version != _VERSION:
        message = f"is a sweep of version {printable(str(version))}; this rosorin-compile reads version {_VERSION}"
        raise _NotByLine(True, message, line, number, 1)
    arguments = said.get("arguments")
    return Head(str(said.get("description", "")), arguments if isinstance(arguments, dict) else {})
