"""Translate a xacro to a description with its macros and arguments, verified against what xacro makes.

A child process writes the documents (``program``). What cannot be translated is given up there by name: a macro is
expanded where it is called, an argument keeps its value. The result is compiled, and what differs names what is given
up next.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.imported_robot import Imported, Outputs, ReadOptions
from rosorin_compile.source.diagnostics import count_of, phrase
from rosorin_compile.source.files import exists, read_text
from rosorin_compile.source.project import Description
from rosorin_compile.source.xml.markup import MarkupError

from ..description import _Document, _written, sorted_sections, tree_of
from ..layout import Remarks, Verbatim, layout
from .expand import _expand
from .verify import Combination, Comparison, Fault, Source, combinations, compare
from .write_yaml import decode

MAX_ATTEMPTS = 25
MAX_SECONDS = 45.0  # of CPU, with its children
# What is made of the xacro begins and ends a file, in this order; other sections are between.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")


class Target(NamedTuple):
    """Where a description is going to be, and what it has other than the xacro.

    ``schema`` is the address of the schema for editors; ``name`` another name of the robot; ``meshes`` is put before
    relative names of meshes. ``shares``: files are included from other descriptions next to it that have the same.
    """

    folder: Path
    schema: str = ""
    name: str | None = None
    meshes: str | None = None
    shares: bool = False

    def address(self, name: str, text: str) -> str:
        """Return the name of a file as the description includes it: that of another description if it is the same."""
        if not self.shares or exists(self.folder / name):
            return name
        others = (
            one for one in sorted(self.folder.parent.glob(f"*/{name}")) if read_text(one, errors="replace") == text
        )
        return next((f"../{one.relative_to(self.folder.parent).as_posix()}" for one in others), name)


class InlinedMacro(NamedTuple):
    """A macro that is expanded where it is called, with the reason."""

    name: str
    reason: str
    at: str = ""


@dataclass(frozen=True)
class Translation:
    """The files of a description (text by name), and what became of the macros and arguments of the source.

    ``fixed`` are arguments with the value that they keep, ``proven`` the combinations of arguments that were compared.
    ``report`` are the lines for the person who imports the robot. Without files, ``reason`` says why.
    """

    files: dict[str, str]
    kept: tuple[str, ...] = ()
    inlined: tuple[InlinedMacro, ...] = ()
    arguments: tuple[str, ...] = ()
    fixed: tuple[tuple[str, str], ...] = ()
    proven: tuple[Combination, ...] = ()
    report: tuple[str, ...] = ()
    reason: str = ""


class _Flat(Exception):
    """The xacro cannot be translated at all."""


def translate(path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, target: Target) -> Translation:
    """Return the description of a xacro; without files, and with a reason, if it cannot be translated.

    ``imported`` is the robot that the xacro expands to with the arguments that are given, ``wanted`` the artifacts that
    its description asks for.
    """
    try:
        return _Search(path, options, imported, wanted, target).run()
    except MarkupError as problem:
        reason = problem.diagnostic.message
    except (_Flat, OSError) as problem:
        reason = str(problem)
    return Translation({}, report=(f"flat, without macros and arguments: {reason}",), reason=reason)


def _seconds() -> float:
    """Return the CPU time of the process and its children."""
    return sum(os.times()[:4])


class _Search:
    """The search for what has to be given up."""

    def __init__(self, path: Path, options: ReadOptions, imported: Imported, wanted: Outputs, target: Target) -> None:
        self.path, self.options, self.imported, self.target = path, options, imported, target
        self.outputs = dict(wanted.entries)
        if "urdf" in self.outputs:  # kept elements need no hardware or sensors of Gazebo
            urdf = self.outputs["urdf"]
            self.outputs["urdf"] = {key: one for key, one in urdf.items() if key not in ("control", "gazebo")}
        self.source = Source(path, options, target.name, target.meshes)
        self.source.known[()] = imported
        self.inlined: dict[str, str] = {}  # places of macros, with the reason
        self.fixed: dict[str, list[str]] = {}  # values of arguments, with the reason
        self.began = _seconds()

    def run(self) -> Translation:
        failing: Combination | None = None
        for _ in range(MAX_ATTEMPTS):
            answer = self.answer()
            choices = {one["name"]: one["choices"] for one in answer["arguments"]}
            self.source.environment = [one["name"] for one in answer["arguments"] if one["environment"]]
            rows, possible = combinations(choices)
            invented = [((one["name"], text),) for one in answer["arguments"] for text in one["invented"]]
            rows = sorted([*rows, *invented], key=lambda row: row != failing)  # what failed before fails first
            files = self.files(answer)
            packages = {**self.options.packages, **{name: Path(one) for name, one in answer["packages"].items()}}
            result = compare(files, self.source, rows, packages, self.is_late)
            if not result.faults and self.acceptances() != self.accepted_before:
                continue  # other arguments break other rules
            if result.faults:
                failing = result.faults[0].combination
                self.give_up(answer, result.faults)
            elif not self.fix_refused(answer, rows, result.refused):
                rows = [row for row in rows if row not in invented]
                return self.finish(answer, files, result, rows, possible > len(rows))
        raise _Flat("nothing that was given up makes it the same robot")

    def answer(self) -> dict[str, Any]:
        """Return the documents with what has been given up so far."""
        if self.is_late():
            raise _Flat(f"the translation takes more than {MAX_SECONDS:g} s")
        folder = os.path.abspath(self.target.folder)
        plan = {"inlined": self.inlined, "fixed": self.fixed, "folder": folder, "meshes": self.target.meshes}
        answer = _expand(self.path, self.options, plan)
        if "error" in answer:
            raise _Flat(str(answer["error"]))
        self.inlined, self.fixed = answer["inlined"], answer["fixed"]
        return answer

    def is_late(self) -> bool:
        return _seconds() - self.began > MAX_SECONDS

    def acceptances(self) -> list[Any]:
        """Return what the robots of all combinations have to be accepted for; each rule once."""
        made: dict[tuple[str, str], dict[str, Any]] = {}
        for imported in self.source.known.values():
            for entry in (imported.tree.get("accept") if imported.tree is not None else None) or ():
                key = (str(entry["rule"]), str(entry.get("reason") or ""))
                known = made.setdefault(key, {"rule": key[0], "of": [], "reason": key[1]})
                known["of"] += [str(one) for one in entry.get("of") or () if str(one) not in known["of"]]
        return [{name: value for name, value in entry.items() if value} for entry in made.values()]

    # Giving up.

    def give_up(self, answer: Mapping[str, Any], faults: Sequence[Fault]) -> None:
        """Give up the macros that differences name, else the arguments that were changed, else all macros."""
        if self.acceptances() != self.accepted_before:
            return  # other arguments break other rules
        text, _, row = faults[0]
        named = {name for fault in faults for name in fault.macros}
        macros = [key for name, ours, key in answer["macros"] if {name, ours} & named]
        fixed = [name for name, _ in row if name not in self.fixed]
        if not macros and not fixed:
            macros = [key for _, _, key in answer["macros"]]
            fixed = [one["name"] for one in answer["arguments"] if one["used"]]
        if macros:
            self.inlined |= dict.fromkeys(macros, f"not proven: {text}")
            return
        values = {one["name"]: one["value"] for one in answer["arguments"]}
        self.fixed |= {name: [values[name], f"not proven: {text}"] for name in fixed}
        if not fixed:
            raise _Flat(text)

    def fix_refused(
        self, answer: Mapping[str, Any], rows: Sequence[Combination], refused: Sequence[Combination]
    ) -> bool:
        """Fix variables of the environment of which xacro takes no other value than the one they have."""
        found = {}
        for one in answer["arguments"]:
            mine = [row for row in rows if len(row) == 1 and row[0][0] == one["name"]]
            if one["environment"] and mine and all(row in refused for row in mine):
                reason = f"with another value of the environment variable {one['name']} xacro makes no robot"
                found[one["name"]] = [one["value"], reason]
        self.fixed |= found
        return bool(found)

    # The result.

    def files(self, answer: Mapping[str, Any]) -> dict[str, str]:
        """Return the files of the description."""
        tree, root = tree_of(self.imported), Description.ROOT_FILE
        documents: dict[str, Any] = decode(answer["documents"])
        documents = {name: {key: one for key, one in made.items() if one} for name, made in documents.items()}
        remarks: dict[str, dict[tuple[Any, ...], list[str]]] = {}
        for file, path, lines in answer["remarks"]:
            remarks.setdefault(file, {}).setdefault(tuple(path), []).extend(lines)

        def text(name: str, content: Mapping[str, Any], first: Sequence[str] = ()) -> str:
            lines = Remarks({(): [*first, *answer["heads"].get(name, ())], **remarks.get(name, {})})
            return layout({key: content[key] for key in sorted(content, key=_rank) if content[key]}, lines)

        made = {name: text(name, one) for name, one in documents.items() if name != root and one}
        if not answer["copied"]:  # tables are named from the file
            made = {self.target.address(name, one): one for name, one in made.items()}
        head: dict[str, Any] = {"rosorin_compile": Verbatim("1"), "robot": self.target.name or decode(answer["name"])}
        head |= {"source": dict(tree["source"])} if "source" in tree else {}
        head |= {"include": list(made)} if made else {}
        document = _Document(tree)
        others = {name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)}
        tail = {name: document.value(value, (name,), None) for name, value in sorted_sections(others).items()}
        self.accepted_before = self.acceptances()
        tail["accept"] = self.accepted_before
        tail["outputs"] = {one: _written(entry) for one, entry in self.outputs.items()}
        first = [f"yaml-language-server: $schema={self.target.schema}"] if self.target.schema else []
        return {root: text(root, {**head, **tail, **documents.get(root, {})}, first), **made, **answer["copied"]}

    def finish(
        self,
        answer: Mapping[str, Any],
        files: dict[str, str],
        result: Comparison,
        rows: Sequence[Combination],
        is_part: bool,
    ) -> Translation:
        kept = tuple({key: name for name, _, key in answer["macros"]}.values())
        lost = tuple(InlinedMacro(*one) for one in answer["lost"])
        used = tuple(one["name"] for one in answer["arguments"] if one["used"])
        refused = [row for row in result.refused if row in rows]
        late = len([row for row in rows if row not in result.compared]) - len(refused)
        report = [*_report_macros(kept, lost, answer), *self.report_arguments(answer, used)]
        for package in answer["unfound"]:
            report.append(
                f"it asks for the package {package}: source its workspace, or give --package {package}=FOLDER"
            )
        report += _report_proof(result.compared, is_part, refused, late)
        fixed = tuple((name, value) for name, (value, _) in self.fixed.items())
        files = {name: text for name, text in files.items() if not name.startswith("../")}
        return Translation(files, kept, lost, used, fixed, tuple(result.compared), tuple(report))

    def report_arguments(self, answer: Mapping[str, Any], used: Sequence[str]) -> Iterator[str]:
        """Yield the lines about arguments."""
        unused = [one["name"] for one in answer["arguments"] if one["name"] not in (*used, *self.fixed)]
        environment = [one["name"] for one in answer["arguments"] if one["environment"] and one["name"] in used]
        if used:
            yield f"arguments kept: {phrase(list(used))}"
        if unused:
            yield f"arguments left out, because nothing uses {_them(unused)}: {phrase(unused)}"
        if environment:
            yield f"variables of the environment that are arguments now: {phrase(environment)}"
        if self.fixed:
            values = [f"{name} ({' '.join(text.split())})" if text else name for name, (text, _) in self.fixed.items()]
            yield f"arguments replaced by their value: {phrase(values)}"
        for reason, names in groupby(self.fixed, lambda name: self.fixed[name][1]):
            yield f"  {phrase(list(names))}: {reason}"


def _report_macros(kept: Sequence[str], lost: Sequence[InlinedMacro], answer: Mapping[str, Any]) -> Iterator[str]:
    if kept or lost:
        line = f"{len(kept)} of {count_of(len(kept) + len(lost), 'macro')} kept"
        how = f", {len(lost)} written out where {'it is' if len(lost) == 1 else 'they are'} called"
        yield f"{line}{how}" if lost else line
    yield from (f"  {one.name}: {one.reason}{f' ({one.at})' if one.at else ''}" for one in lost)
    executed, idle = answer["silent"], list(dict.fromkeys(answer["uncalled"]))
    if executed:
        yield f"named values where they are called, because they only set properties: {phrase(executed)}"
    if idle:
        yield f"left out, because nothing calls {_them(idle)}: {phrase(idle)}"


def _report_proof(
    rows: Sequence[Combination], is_part: bool, refused: Sequence[Combination], late: int
) -> Iterator[str]:
    how = "its arguments as they are" if len(rows) == 1 else f"{len(rows)} combinations of its arguments"
    if is_part:
        how += " (the defaults, and each argument changed alone)"
    yield f"the same robot as xacro makes it, with {how}"
    if late:
        yield f"not compared, because that takes too long: {count_of(late, 'combination')}"
    if refused:
        first = " ".join(f"{name}:={value}" for name, value in refused[0])
        yield f"not compared, because xacro refuses it: {first}"


def _them(items: Sequence[Any]) -> str:
    return "it" if len(items) == 1 else "them"


def _rank(key: str) -> int:
    return _HEAD.index(key) if key in _HEAD else 100 + _TAIL.index(key) if key in _TAIL else 50
