"""Translate a xacro to a description that keeps its macros and arguments, and verify it against xacro.

A child process writes the documents (``program``). Macros that cannot be translated are expanded, and arguments that
cannot be translated are replaced by their values. The result is compiled for combinations of the arguments and compared
with the output of xacro. If they differ, the next attempt does not keep the macro or argument at fault.
"""

import itertools
import math
import os
import posixpath
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot, Outputs, ReadOptions
from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.language.expand.included_robots import move_files
from rosorin_compile.source.diagnostics import Diagnostic, count_of, has_errors, phrase
from rosorin_compile.source.files import exists, read_text
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.xml.elements import canonical, tree_of
from rosorin_compile.source.xml.markup import MarkupError

from ..description import Remarks, Verbatim, document_value, layout, plain_value, sorted_sections
from ..round_trip import model_differences
from .expand import _expand
from .write_yaml import decode

MAX_ATTEMPTS = 25
MAX_SECONDS = 45.0  # CPU time, including child processes
MAX_COMBINATIONS = 16
# The sections at the beginning and at the end of a file, in this order.
_HEAD = ("rosorin_compile", "robot", "source", "include", "args", "let", "materials", "parts", "links", "joints", "use")
_TAIL = ("urdf_elements", "accept", "outputs")

Combination = tuple[tuple[str, str], ...]  # (name, value) of each argument that differs from its default
_Rows = Sequence[Combination]


class Target(NamedTuple):
    """The destination of a translated description, and requested differences from the xacro (``name``, ``meshes``)."""

    folder: Path
    schema: str = ""  # path of the JSON schema for editors
    name: str | None = None  # new name of the robot
    meshes: str | None = None  # prefix for relative mesh file names
    shares: bool = False  # True to include equal files of sibling descriptions

    def address(self, name: str, text: str) -> str:
        """Return the path for including a file: an equal file of a sibling description if ``shares``, else ``name``."""
        if self.shares and not exists(self.folder / name):
            for path in sorted(self.folder.parent.glob(f"*/{name}")):
                if read_text(path, errors="replace") == text:
                    return f"../{path.relative_to(self.folder.parent).as_posix()}"
        return name


class Translation(NamedTuple):
    """The text of each description file by name ({} if the translation failed), and lines of the import report."""

    files: dict[str, str]
    report: Sequence[str]


class _Flat(Exception):
    """The xacro cannot be translated, only expanded; the message is the reason."""


class _Fault(NamedTuple):
    """A difference between a translation and the output of xacro; ``combination`` has the arguments."""

    text: str
    macros: list[list[str]]  # for each difference, the macros that may cause it, innermost first
    combination: Combination


def translate(path: Path, options: ReadOptions, robot: ImportedRobot, wanted: Outputs, target: Target) -> Translation:
    """Translate a xacro to a description. If that fails, the result has no files, and ``report`` has the reason.

    ``robot`` is the robot that the xacro expands to with the arguments in ``options``. ``wanted`` is the section
    ``outputs`` of the description.
    """
    try:
        return _Search(path, options, robot, wanted, target).run()
    except (MarkupError, _Flat, OSError) as problem:
        reason = problem.diagnostic.message if isinstance(problem, MarkupError) else str(problem)
    return Translation({}, [f"flat, without macros and arguments: {reason}"])


class _Search:
    """Repeats the translation with fewer macros and arguments until the compiled robot equals the output of xacro."""

    def __init__(self, path: Path, options: ReadOptions, robot: ImportedRobot, wanted: Outputs, target: Target) -> None:
        self.path, self.options, self.imported, self.target = path, options, robot, target
        self.outputs = dict(wanted.entries)
        if "urdf" in self.outputs:  # the xacro has Gazebo and ros2_control elements, so do not generate them
            urdf = self.outputs["urdf"]
            self.outputs["urdf"] = {key: one for key, one in urdf.items() if key not in ("control", "gazebo")}
        self.robots: dict[Combination, ImportedRobot] = {(): robot}  # arguments -> robot that xacro generates
        self.inlined: dict[str, str] = {}  # why a macro is expanded, by its source position
        self.fixed: dict[str, list[str]] = {}  # [value, reason] of each replaced argument by name
        self.began = sum(os.times()[:4])  # CPU time in seconds, including child processes

    def run(self) -> Translation:
        failing: Combination | None = None
        for _ in range(MAX_ATTEMPTS):
            if self.is_late():
                raise _Flat(f"the translation takes more than {MAX_SECONDS:g} s")
            folder = os.path.abspath(self.target.folder)
            plan = {"inlined": self.inlined, "fixed": self.fixed, "folder": folder, "meshes": self.target.meshes}
            answer = _expand(self.path, self.options, plan)
            if "error" in answer:
                raise _Flat(str(answer["error"]))
            self.inlined, self.fixed = answer["inlined"], answer["fixed"]
            rows, total = _combinations({one["name"]: one["choices"] for one in answer["arguments"]})
            invented = [((one["name"], text),) for one in answer["arguments"] for text in one["invented"]]
            every = sorted([*rows, *invented], key=lambda row: row != failing)  # the last failure first
            variables = {one["name"]: one["value"] for one in answer["arguments"] if one["environment"]}
            refused = self.expand(every, variables)
            rejected = {
                name: [value, f"with another value of the environment variable {name} xacro makes no robot"]
                for name, value in variables.items()
                if (rows_of := [row for row in every if len(row) == 1 and row[0][0] == name])
                and all(row in refused for row in rows_of)
            }
            if rejected.keys() - self.fixed.keys():
                self.fixed |= rejected
                continue
            files = self.files(answer)
            packages = {**self.options.packages, **{name: Path(one) for name, one in answer["packages"].items()}}
            compared = self.compare(files, [row for row in every if row not in refused], packages)
            if isinstance(compared, _Fault):
                failing = compared.combination
                self.give_up(answer, compared)
                continue
            written = {name: text for name, text in files.items() if not name.startswith("../")}
            return Translation(written, [*self.report(answer, rows, refused, compared, total)])
        raise _Flat("nothing that was given up makes it the same robot")

    def is_late(self) -> bool:
        return sum(os.times()[:4]) - self.began > MAX_SECONDS

    def expand(self, rows: _Rows, variables: Mapping[str, str]) -> list[Combination]:
        """Expand the xacro for new combinations of arguments; return the combinations for which xacro fails.

        ``variables`` are arguments that are environment variables in the xacro. At the time limit, the method stops.
        """
        for number, row in enumerate(rows):
            if row not in self.robots and (number < 2 or not self.is_late()):
                arguments = {name: text for name, text in row if name not in variables}
                arguments = {**self.options.arguments, **arguments}
                options = self.options._replace(trust=True, tell=None, arguments=arguments)
                if changed := {name: text for name, text in row if name in variables}:
                    options = options._replace(environment={**(options.environment or os.environ), **changed})
                read = read_robot(self.path, options)
                if self.target.meshes is not None and read.tree is not None:
                    read = read._replace(tree=move_files(read.tree, self.target.meshes))
                self.robots[row] = read
        made = [(row, self.robots[row]) for row in rows if row in self.robots]
        return [row for row, one in made if one.tree is None or has_errors(one.diagnostics)]

    def compare(self, files: Mapping[str, str], rows: _Rows, packages: Mapping[str, Path]) -> _Rows | _Fault:
        """Compare a translation with the output of xacro; return the combinations that are equal, or a difference."""
        compared: list[Combination] = []
        with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
            stage = Path(name, Description.FOLDER, "robot")  # a subfolder, so that ../NAME is in the temporary folder
            for file, text in files.items():
                (stage / file).parent.mkdir(parents=True, exist_ok=True)
                (stage / file).write_text(text, "utf-8")
            for number, row in enumerate(rows):
                if row not in self.robots or (number > 1 and self.is_late()):
                    break
                Progress.step("proving the translation", number, len(rows))
                compiled = compile_robot(stage / Description.ROOT_FILE, dict(row), packages=dict(packages), exact=True)
                source = self.robots[row].robot
                if has_errors(compiled.diagnostics) or compiled.robot is None or source is None:
                    return _error(compiled.diagnostics, stage, row)
                source = replace(source, name=self.target.name or source.name)
                if texts := model_differences(_settled(source), _settled(compiled.robot)):
                    return _Fault(texts[0][:200], _calls(texts, self.robots[row]), row)
                compared.append(row)
        return compared

    def give_up(self, answer: Mapping[str, Any], fault: _Fault) -> None:
        """Exclude the macros that cause a fault from the next attempt, or else the arguments, or else everything."""
        kept = {name: key for name, ours, key in answer["macros"] for name in (name, ours)}
        macros = {kept[found[0]] for names in fault.macros if (found := [name for name in names if name in kept])}
        fixed = [name for name, _ in fault.combination if name not in self.fixed]
        if not macros and not fixed:
            macros = set(kept.values())
            fixed = [one["name"] for one in answer["arguments"] if one["used"]]
        reason = f"not proven: {fault.text}"
        if macros:
            self.inlined |= dict.fromkeys(macros, reason)
        elif fixed:
            values = {one["name"]: one["value"] for one in answer["arguments"]}
            self.fixed |= {name: [values[name], reason] for name in fixed}
        else:
            raise _Flat(fault.text)

    def files(self, answer: Mapping[str, Any]) -> dict[str, str]:
        tree, root = self.imported.whole, Description.ROOT_FILE
        documents: dict[str, Any] = decode(answer["documents"])
        remarks: dict[str, dict[tuple[Any, ...], list[str]]] = {}
        for file, path, lines in answer["remarks"]:
            remarks.setdefault(file, {}).setdefault(tuple(path), []).extend(lines)

        def text(name: str, content: Mapping[str, Any], first: Sequence[str] = ()) -> str:
            lines = Remarks({(): [*first, *answer["heads"].get(name, ())], **remarks.get(name, {})})
            keys = [*_HEAD, *(key for key in content if key not in (*_HEAD, *_TAIL)), *_TAIL]
            return layout({key: content[key] for key in keys if content.get(key)}, lines)

        made = {name: text(name, one) for name, one in documents.items() if name != root and any(one.values())}
        if not answer["copied"]:  # a shared file could not load copied YAML files
            made = {self.target.address(name, one): one for name, one in made.items()}
        head: dict[str, Any] = {"rosorin_compile": Verbatim("1"), "robot": self.target.name or decode(answer["name"])}
        head |= {"source": dict(tree["source"])} if "source" in tree else {}
        head |= {"include": list(made)} if made else {}
        others = {name: value for name, value in tree.items() if name not in (*_HEAD, *_TAIL)}
        tail = {name: document_value(tree, value, (name,)) for name, value in sorted_sections(others).items()}
        tail |= {"accept": self.acceptances(), "outputs": plain_value(self.outputs)}
        first = [f"yaml-language-server: $schema={self.target.schema}"] if self.target.schema else []
        return {root: text(root, {**head, **tail, **documents.get(root, {})}, first), **made, **answer["copied"]}

    def acceptances(self) -> list[Any]:
        """Return the ``accept`` entries (suppressed diagnostics) of all expanded robots, merged by rule and reason."""
        made: dict[tuple[str, str], dict[str, Any]] = {}
        for imported in self.robots.values():
            for entry in (imported.tree.get("accept") if imported.tree is not None else None) or ():
                key = (str(entry["rule"]), str(entry.get("reason") or ""))
                known = made.setdefault(key, {"rule": key[0], "of": [], "reason": key[1]})
                known["of"] += [str(one) for one in entry.get("of") or () if str(one) not in known["of"]]
        return [{name: value for name, value in entry.items() if value} for entry in made.values()]

    def report(
        self, answer: Mapping[str, Any], rows: _Rows, refused: _Rows, compared: _Rows, total: int
    ) -> Iterator[str]:
        kept, lost = {key for _, _, key in answer["macros"]}, answer["lost"]
        if kept or lost:
            line = f"{len(kept)} of {count_of(len(kept) + len(lost), 'macro')} kept"
            how = f", {len(lost)} written out where {'it is' if len(lost) == 1 else 'they are'} called"
            yield f"{line}{how}" if lost else line
        yield from (f"  {name}: {reason} ({place})" for name, reason, place in lost)
        arguments = answer["arguments"]
        unused = [one["name"] for one in arguments if not one["used"] and one["name"] not in self.fixed]
        idle = list(dict.fromkeys(answer["uncalled"]))
        lists = {
            "named values where they are called, because they only set properties": answer["silent"],
            f"left out, because nothing calls {_them(idle)}": idle,
            "arguments kept": [one["name"] for one in arguments if one["used"]],
            f"arguments left out, because nothing uses {_them(unused)}": unused,
            "variables of the environment that are arguments now": [
                one["name"] for one in arguments if one["environment"] and one["used"]
            ],
            "arguments replaced by their value": [
                f"{name} ({' '.join(text.split())})" if text else name for name, (text, _) in self.fixed.items()
            ],
        }
        yield from (f"{head}: {phrase(names)}" for head, names in lists.items() if names)
        for reason, names in groupby(self.fixed, lambda name: self.fixed[name][1]):
            yield f"  {phrase(list(names))}: {reason}"
        for package in answer["unfound"]:
            yield f"it asks for the package {package}: source its workspace, or give --package {package}=FOLDER"
        how = "its arguments as they are" if len(compared) == 1 else f"{len(compared)} combinations of its arguments"
        how += " (the defaults, and each argument changed alone)" if total > len(rows) else ""
        yield f"the same robot as xacro makes it, with {how}"
        if late := [row for row in rows if row not in compared and row not in refused]:
            yield f"not compared, because that takes too long: {count_of(len(late), 'combination')}"
        if first := next((row for row in refused if row in rows), None):
            yield f"not compared, because xacro refuses it: {' '.join(f'{name}:={value}' for name, value in first)}"


def _combinations(choices: Mapping[str, Sequence[str]]) -> tuple[list[Combination], int]:
    """Return (combinations to compare, total number of combinations); the defaults come first."""
    several = {name: values for name, values in choices.items() if len(values) > 1}
    total = math.prod(map(len, several.values()))
    if total <= MAX_COMBINATIONS:
        rows = [dict(zip(several, row, strict=True)) for row in itertools.product(*several.values())]
    else:
        rows = [{}, *({name: value} for name, values in several.items() for value in values[1:])]
    made = [tuple((name, value) for name, value in row.items() if value != several[name][0]) for row in rows]
    return list(dict.fromkeys(made)), total


def _error(diagnostics: Sequence[Diagnostic], stage: Path, row: Combination) -> _Fault:
    """Convert compiler errors to a fault, with the names of the parts and ``let`` functions that cause them."""
    errors = [one for one in diagnostics if has_errors([one])]
    macros: list[list[str]] = []
    for one in errors:
        for place in filter(None, (one.span, *(related.span for related in one.related))):
            lines = place.source.text.splitlines()[: place.line]
            macros.append([match[1] for line in lines if (match := re.match(r"  ([\w.-]+)[(:]", line))][-1:])
        macros += [[name] for related in one.related for name in re.findall(r'part "(\w+)"', related.message)]
    span = errors[0].span if errors else None
    text = errors[0].message.replace(f"{stage}/", "") if errors else "what is compiled is not a robot"
    return _Fault(text + (f" ({Path(span.source.path).name}:{span.line})" if span else ""), macros, row)


def _calls(texts: Sequence[str], made: ImportedRobot) -> list[list[str]]:
    """For each link, joint and element named in ``texts``, return the macros that created it, innermost first."""
    names, tree = set(re.findall(r"[\w./-]+", " ".join(texts))), made.whole
    spans = []
    for section in ("links", "joints"):
        spans += [tree[section].value_spans[name] for name in tree.get(section) or () if name in names]
    for number, text in enumerate(tree.get("urdf_elements") or ()):
        root = tree_of(str(text))
        if root.tag in names or root.get("reference") in names:
            spans.append(tree["urdf_elements"].value_spans[number])
    calls = [" ".join(one.message for one in getattr(span, "via", ())) for span in spans]
    return [re.findall(r'the macro "([^"]+)"', text) for text in calls]


def _settled(value: Any) -> Any:
    """Normalize XML elements and mesh file names of a robot, so that equivalent robots compare equal."""
    if not is_dataclass(value) or isinstance(value, type):
        return value
    changes: dict[str, Any] = {}
    for field in fields(value):
        inner = getattr(value, field.name)
        if field.name == "urdf_elements":
            changes[field.name] = tuple(sorted(canonical(tree_of(one)) for one in inner))
        elif field.name == "geometry" and "://" in (file := str(getattr(inner, "file", ""))) and "/../" in file:
            scheme, sign, rest = file.partition("://")
            changes[field.name] = replace(inner, file=f"{scheme}{sign}{posixpath.normpath(rest)}")
        elif field.name in ("links", "joints", "visual", "collision") and isinstance(inner, tuple):
            changes[field.name] = tuple(map(_settled, inner))
    return replace(value, **changes) if changes else value


def _them(items: Sequence[Any]) -> str:
    return "it" if len(items) == 1 else "them"
