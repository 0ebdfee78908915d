"""Making: one variant of a sweep, from its arguments to the folder of its artifacts, and knowing one that is made.

The index, ``sweep.json``, is a JSON object whose ``variants`` stand in a line each; where ``-a`` gives arguments for
all, they are its ``arguments``. A line is a JSON object: ``name``, ``folder``, ``arguments`` as they were given,
``status`` (made or error), ``artifacts`` (SHA-256 by name) and ``diagnostics`` as ``--format json`` has them. Nothing
in it depends on the time, on the machine or on who made it.
"""

from __future__ import annotations

import json
import math
import os
import zlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile import Variant
from rosorin_compile.diagnostics import Diagnostic, Progress, Related, has_errors
from rosorin_compile.extending import (
    Description,
    Given,
    Holding,
    Map,
    OutputError,
    Quantity,
    Seq,
    Text,
    tool_folders,
    world,
)

from .folder import Record, VariantsFolder
from .remote import RemoteFolder

if TYPE_CHECKING:
    from rosorin_compile import Compiled

Folder = VariantsFolder | RemoteFolder
Kept = dict[Path, Any]  # what was read of a description, by its first file (see compile_robot)
Row = tuple[str, str, str]  # what was asked, of what, and the answer
MADE, UNCHANGED, ERROR = "made", "unchanged", "error"


class Job(NamedTuple):
    """What is the same for all variants: the description, arguments that hold for all, packages, and whom to trust.

    ``key`` tells this job from others.
    """

    description: Description
    shared: dict[str, Any]
    packages: dict[str, Path]
    trust: bool
    key: str


class Made(NamedTuple):
    """What became of a variant: its line of the index, how that came about, and the bytes of its artifacts.

    ``made_of`` is the name under which the folder knows the files that it was made of. ``fatal`` is why nothing can be
    written any more.
    """

    line: str
    state: str
    size: int = 0
    made_of: str = ""
    edited: bool = False
    fatal: Diagnostic | None = None


def job(description: Description, shared: dict[str, Any], packages: Mapping[str, Path], trust: bool, out: Path) -> Job:
    """Return what is the same for all variants of a sweep into the folder ``out``."""
    told = {
        "description": [os.path.relpath(description.path, out), world.shown(description.path)],
        "arguments": typed(shared),
        "packages": {name: os.path.abspath(folder) for name, folder in packages.items()},
        "trust": trust,
    }
    key = Holding.digest(json.dumps(told, sort_keys=True).encode())
    return Job(description, shared, dict(packages), trust, key)


class Maker:
    """Makes variants of a job, in one process."""

    def __init__(self, job: Job, folder: Folder) -> None:
        self.job = job
        self.folder = folder
        self.kept: Kept = {}
        self.fresh = lru_cache(maxsize=10_000)(self._fresh)
        self.answer = lru_cache(maxsize=100_000)(world.answer)  # what is asked for many variants is asked once

    def made_before(self, variant: Variant) -> Made | None:
        """Return what is known of a variant that is made already, by this job, and whole; else None."""
        record = self.folder.record(variant.name)
        if record is None or record.key != self._key(variant):
            return None
        if record.at and record.at != _places(variant):
            return None
        if not record.made_of or not self.fresh(record.made_of):
            return None
        artifacts = record.artifacts
        if not self.folder.holds(variant.name, artifacts):
            return None
        return Made(record.line, UNCHANGED, 0, record.made_of)

    def make(self, variant: Variant) -> Made:
        """Make a variant; what is wrong with it is told in its line."""
        with Progress.within(), world.noting() as notes:
            world.note_tool()
            compiled = self.compiled(variant)
        return self.finished(variant, compiled, notes.rows())

    def finished(self, variant: Variant, compiled: Compiled, rows: Sequence[Row]) -> Made:
        """Write what became of a variant; ``rows`` are what was asked for it, and answered."""
        files: dict[str, bytes] = {}
        said = [*variant.diagnostics, *compiled.diagnostics]
        try:
            if not has_errors(said):
                files = compiled.files()
        except OutputError as problem:
            said.append(problem.diagnostic)
        line = line_of(variant, {name: Holding.digest(data) for name, data in files.items()}, said)
        return self.take(variant, line, files, self.asked(variant, rows) if files else [])

    def asked(self, variant: Variant, rows: Sequence[Row]) -> list[Row]:
        """Return what was asked for a variant.

        Its own folder is held against what was written there, and the tool is known as a whole: who was first in a
        process to need a file of it would have other notes than the others.
        """
        own = (os.path.abspath(self.folder.place(variant.name)), *map(str, tool_folders().values()))
        inside = tuple(folder + os.sep for folder in own)
        return [row for row in rows if row[1] not in own and not row[1].startswith(inside)]

    def take(
        self,
        variant: Variant,
        line: str,
        files: Mapping[str, bytes],
        asked: Sequence[Row],
    ) -> Made:
        """Write the artifacts of a variant. ``asked`` is what was asked for it, and answered; none if nobody knows."""
        try:
            return self._put(variant, line, files, asked)
        except OutputError as problem:
            entry = {**json.loads(line), "status": ERROR, "artifacts": {}}
            entry["diagnostics"].append(problem.diagnostic.as_object())
            return Made(json.dumps(entry), ERROR)
        except OSError as problem:
            return Made(line, ERROR, fatal=self.folder.explained(problem).diagnostic)

    def compiled(self, variant: Variant) -> Compiled:
        """Return what becomes of a variant; nothing is written."""
        from rosorin_compile import Compiled
        from rosorin_compile.extending import compile_robot

        if has_errors(variant.diagnostics):
            return Compiled(None, (), [], ())
        given = Given({}, (), self.job.packages, self.job.trust)
        path = self.job.description.path
        placed = replace(self.job.description, outputs=self.folder.place(variant.name))
        search = partial(given.search_meshes, placed)
        tell = _silent if self.job.trust else None
        arguments = merged(self.job.shared, variant)
        return compile_robot(path, arguments, tell, given.packages, search, kept=self.kept).proven()

    def _put(
        self,
        variant: Variant,
        line: str,
        files: Mapping[str, bytes],
        asked: Sequence[Row],
    ) -> Made:
        """Write the artifacts of a variant, as ``take``. Raises OutputError, OSError."""
        entry, before = json.loads(line), self.folder.record(variant.name)
        if entry["status"] == ERROR:
            if before is not None:
                self.folder.drop(variant.name)
            return Made(line, ERROR)
        made_of = self.folder.keep_made_of({"asked": [list(one) for one in asked]}) if asked else ""
        at = _places(variant) if _names_list(variant, entry["diagnostics"]) else 0
        record = Record(self._key(variant), made_of, at, line)
        edited = (
            before is not None
            and (before.key, before.made_of) == (record.key, made_of)
            and made_of != ""
            and not self.folder.holds(variant.name, before.artifacts)
        )
        self.folder.put(variant.name, files, record)
        return Made(line, MADE, sum(map(len, files.values())), made_of, edited)

    def _key(self, variant: Variant) -> str:
        told = json.dumps([self.job.key, variant.name, typed(variant.arguments)], sort_keys=True)
        return Holding.digest(told.encode("utf-8", "surrogatepass"))

    def _fresh(self, made_of: str) -> bool:
        """Say whether what was asked for a variant is answered as it was."""
        known = self.folder.made_of(made_of)
        try:
            return known is not None and all(self.answer(*question) == said for *question, said in known["asked"])
        except (OSError, KeyError, TypeError, ValueError):
            return False


def compiled_here(first: Path, given: Given, variant: Variant, kept: Kept | None = None) -> Compiled:
    """Return what becomes of one variant, for the library."""
    from rosorin_compile import Compiled
    from rosorin_compile.extending import compile_robot

    if has_errors(variant.diagnostics):
        return Compiled(None, (), list(variant.diagnostics), (), variant=variant)
    compiled = compile_robot(first, merged(given.values(), variant), packages=given.packages, kept=kept)
    return replace(compiled, diagnostics=[*variant.diagnostics, *compiled.diagnostics], variant=variant)


def merged(shared: Mapping[str, Any], variant: Variant) -> Map:
    """Return the arguments of a variant: its own, before those of all."""
    made = Map(variant.arguments.span)
    for arguments in (shared, variant.arguments):
        for name, value in arguments.items():
            made[name] = value
            if isinstance(arguments, Map) and name in arguments.value_spans:
                made.key_spans[name] = arguments.key_spans[name]
                made.value_spans[name] = arguments.value_spans[name]
    return made


def line_of(variant: Variant, artifacts: Mapping[str, str], said: list[Diagnostic]) -> str:
    """Return the line of a variant in the index: a JSON object."""
    entry = {
        "name": variant.name,
        "folder": variant.name,
        "arguments": plain(variant.arguments),
        "status": ERROR if has_errors(said) else MADE,
        "artifacts": dict(sorted(artifacts.items())),
        "diagnostics": [one.as_object() for one in _placed(variant, said)],
    }
    return json.dumps(entry)


def _placed(variant: Variant, said: list[Diagnostic]) -> list[Diagnostic]:
    """Return what there is to say; an error in the description names the place of the variant, too."""
    if variant.span is None:
        return said
    here = Related(f"of the variant {variant.name}", variant.span)
    own = variant.span.source.path
    return [
        replace(one, related=(*one.related, here))
        if one.severity == ERROR and (one.span is None or one.span.source.path != own)
        else one
        for one in said
    ]


def plain(value: Any) -> Any:
    """Return a value of an argument as JSON has it; a quantity as it was written."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list):
        return [plain(one) for one in value]
    if isinstance(value, Quantity) and value.text:
        return value.text
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else str(float(value))
    return str(value) if isinstance(value, str) else value


def typed(value: Any) -> Any:
    """Return a value of an argument as JSON that tells it from all that mean something else."""
    if isinstance(value, dict):
        return {"table": [[str(key), typed(one)] for key, one in value.items()]}
    if isinstance(value, (list, Seq)):
        return [typed(one) for one in value]
    if isinstance(value, Quantity):
        return {"quantity": [repr(float(value)), *value.dimension]}
    if isinstance(value, Text):
        return {"text": str(value)}
    return {"number": repr(value)} if isinstance(value, float) else value


def _places(variant: Variant) -> int:
    """Return what tells the places of a variant's arguments from others; never 0."""
    spans = [variant.span, *variant.arguments.value_spans.values()]
    told = repr([(span.source.path, span.line, span.column, span.length) for span in spans if span is not None])
    return zlib.crc32(told.encode("utf-8", "surrogatepass")) + 1


def _names_list(variant: Variant, said: Iterable[Mapping[str, Any]]) -> bool:
    """Say whether something that is said has a place among the arguments of a variant."""
    own = {span.source.path for span in variant.arguments.value_spans.values()}
    return any(place.get("file") in own for one in said for place in (one, *one["related"]))


def _silent(_: Diagnostic) -> None:
    """Say nothing of what is run that is trusted."""
