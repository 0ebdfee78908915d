"""Sharing: what several robots of a package include is imported once, into ``descriptions/common``.

A file is shared if a xacro of the package that is no part of this robot includes it, too, itself or by others. Where a
robot needs more of it than the others, it grows, if all of them stay what they are. What it becomes can still be the
robot's own: where the same name stands for something else there; ``told`` says why.
"""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

from rosorin_compile.language.arguments import choices, combinations, declared
from rosorin_compile.model import Robot
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, has_errors
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.project import Description

from ..reimport import ENDING, read_record, text_of
from ..same_model import model_differences
from .ir import File, Program
from .merge import Merged, merged, renewed

COMMON = "common"
_MOST_ROBOTS = 32
_MOST, _BYTES = 2000, 2_000_000
_INCLUDE = re.compile(r"<(?:xacro:)?include\s[^<>]*?filename\s*=\s*[\"']([^\"']+)[\"']")
_FIND = re.compile(r"\$\(find\s+([^)\s]+)\)|^package://([^/]+)")


class Sharing:
    """What the robot in a folder of the descriptions of a package shares with others of that package.

    ``shared`` says where the shared ones of its files are, by their name here; ``apart`` why others are not shared;
    ``refused`` are those that cannot be; ``grown`` is what files of others were, by their address.
    """

    def __init__(self, package: Path, folder: Path) -> None:
        self.package = Path(os.path.abspath(package))
        self.folder = folder
        self.shared: dict[str, str] = {}
        self.grown: dict[str, str] = {}
        self.refused: set[str] = set()
        self.apart: dict[str, str] = {}
        self._disturbances: dict[tuple[Path, str], str] = {}
        self._includes: dict[str, set[str]] | None = None

    def placed(self, program: Program, file: File, text: str, theirs: bool) -> tuple[str, str]:
        """Return where others have what a file becomes, as seen from the robot, and what is there then.

        The address is that of a file of its own where it cannot be shared. With ``theirs``, what is there under the
        names of this robot is taken for what this robot needs.
        """
        self.shared.pop(file.name, None)
        before = self._before(file.name, text)
        if before is not None:
            return before
        if file.name in self.refused or not self._is_shared(program, file):
            return file.name, text
        place = self._place(file)
        self.apart.pop(file.name, None)
        same = sorted(self.folder.parent.glob(f"*/**/{Path(file.name).name}"))
        others = [os.path.relpath(one, self.folder) for one in same]
        address, found = self._found(program, file, text, theirs, list(dict.fromkeys((file.name, place, *others))))
        if not address and os.path.lexists(self._at(place)):
            return file.name, text
        self.shared[file.name] = address or place
        return (address, found) if address else (place, text)

    def _before(self, name: str, text: str) -> tuple[str, str] | None:
        """Return where an import before has put a file, and what it is there now; None if it was not there.

        What somebody has edited since is put together with that later: here it is what the import wrote that counts.
        """
        record = read_record(self.folder) if files.is_folder(self.folder) else None
        if record is None:
            return None
        if name in record.files:
            own = f"../{self.folder.name}/{name}"
            others = (_text(one) or "" for one in sorted(self.folder.parent.glob(f"*/{Description.ROOT_FILE}")))
            return name, renewed(record.files[name], text) if any(own in one for one in others) else text
        same = sorted(self.folder.parent.glob(f"*/**/{Path(name).name}{ENDING}"))
        for address in (os.path.relpath(one, self.folder).removesuffix(ENDING) for one in same):
            if any(address in one for one in record.files.values()):
                self.shared[name] = address
                return address, renewed(text_of(self._at(f"{address}{ENDING}")), text)
        return None

    def _found(self, program: Program, file: File, text: str, theirs: bool, addresses: list[str]) -> tuple[str, str]:
        for address in addresses:
            there = _text(self._at(address))
            found = merged(there, text, theirs) if there is not None else None
            if there is None or found is None:
                continue
            if found.text == there:
                return address, there
            if address == file.name:
                continue  # nothing is written over a description of its own
            why = self._disturbed(address, found.text) if found.text else self._why_apart(program, file, found)
            if not why:
                self.grown[address] = there
                return address, found.text
            self.apart.setdefault(file.name, f"{_shown(address)} is another: {why}")
        return "", ""

    def refuse(self, why: str) -> bool:
        """Share no more a file that makes another robot of this one, or none; say whether there is one left."""
        if not self.shared:
            return False
        named = (name for name, address in self.shared.items() if Path(address).name in why)
        name = next(named, next(iter(self.shared)))
        self.refused.add(name)
        self.apart[name] = f"{_shown(self.shared.pop(name))} would make another robot of it: {why}"
        return True

    def report(self, files: Mapping[str, str]) -> Iterator[str]:
        """Yield what became of files that others include, too: a line each."""
        for address, there in self.grown.items():
            if files.get(address, there) != there:
                yield f"{_shown(address)} has more now, and the other robots that include it are the same as before"
        for name, why in self.apart.items():
            if name in files:
                yield f"{name} is of this robot alone, since {why}"

    def _at(self, address: str) -> Path:
        return Path(os.path.normpath(self.folder / address))

    def _why_apart(self, program: Program, file: File, difference: Merged) -> str:
        macros = (one.place for one in program.macros.values() if one.ours == difference.name)
        places = (one.place for one in program.variables.values() if one.name == difference.name and one.place)
        place = next((one for one in (*macros, *places) if program.file_of(one) is file), None)
        return f"line {difference.line}, {difference.reason}{f' ({program.at(place)})' if place else ''}"

    def _disturbed(self, address: str, text: str) -> str:
        file = self._at(address)
        if (file, text) not in self._disturbances:
            self._disturbances[file, text] = disturbed(self.package, self.folder, file, text)
        return self._disturbances[file, text]

    def _place(self, file: File) -> str:
        within = [
            one for one in Path(os.path.abspath(file.path)).relative_to(self.package).parent.parts[1:] if one != COMMON
        ]
        return Path("..", COMMON, *within, Path(file.name).name).as_posix()

    def _is_shared(self, program: Program, file: File) -> bool:
        common = self.folder.parent / COMMON
        if (
            common == self.folder
            or files.exists(common / Description.ROOT_FILE)
            or not Path(os.path.abspath(file.path)).is_relative_to(self.package)
        ):
            return False
        includes = self._graph()
        reached: set[str] = set()
        own = {os.path.abspath(one.path) for one in program.files}
        found = [one for path in includes.keys() - own for one in includes[path]]
        while found:
            path = found.pop()
            if path not in reached:
                reached.add(path)
                found += includes.get(path, ())
        return os.path.abspath(file.path) in reached

    def _graph(self) -> dict[str, set[str]]:
        if self._includes is None:
            paths = [
                os.path.abspath(one) for one in sorted(self.package.glob("**/*.xacro"))[:_MOST] if _is_text_file(one)
            ]
            self._includes = {path: set(self._included(Path(path), paths)) for path in paths}
        return self._includes

    def _included(self, path: Path, paths: list[str]) -> Iterator[str]:
        for name in _INCLUDE.findall(re.sub(r"<!--.*?-->", "", files.read_text(path, errors="replace"), flags=re.S)):
            package = _FIND.match(name)
            rest = _FIND.sub("", name)
            if "$" in rest:  # of a name that is not known by now, its end
                yield from (one for one in paths if "$" not in Path(rest).name and Path(one).name == Path(rest).name)
            elif package is None:
                yield os.path.normpath(path.parent / name)
            elif (package[1] or package[2]) == Packages.name_of(self.package):
                yield os.path.normpath(f"{self.package}/{rest}")


def _is_text_file(path: Path) -> bool:
    return files.is_file(path) and path.stat().st_size <= _BYTES


def _text(path: Path) -> str | None:
    try:
        return files.read_text(path) if path.stat().st_size <= _BYTES else None
    except (OSError, ValueError):
        return None


def _shown(address: str) -> str:
    return f"{Description.FOLDER}/{address.removeprefix('../')}"


def disturbed(package: Path, besides: Path, file: Path, text: str) -> str:
    """Return which robot of a package is another, or cannot be, with another text of a file; empty if none is.

    All descriptions but the one in ``besides`` are compiled before and after, with each choice of their arguments.
    """
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        stage = Path(name, Description.FOLDER)
        shutil.copytree(package / Description.FOLDER, stage, symlinks=True)
        changed = stage / file.relative_to(package / Description.FOLDER)
        packages = {found: package} if (found := Packages.name_of(package)) else {}
        roots = [one for one in sorted(stage.glob(f"*/{Description.ROOT_FILE}")) if one.parent.name != besides.name]
        before = {root: _made(root, packages) for root in roots}
        changed.write_text(text, "utf-8")
        for root in roots:
            why = _other(before[root], _made(root, packages))
            if why:
                return f"with more in it {Description.FOLDER}/{root.parent.name} {why}"
    return ""


def _made(root: Path, packages: Mapping[str, Path]) -> dict[tuple[str, ...], Robot | str]:
    arguments, wrong = declared(root, {}, packages)
    if has_errors(wrong):
        return {(): _in_words(wrong[0])}
    made: dict[tuple[str, ...], Robot | str] = {}
    varied = choices(arguments, {})
    for row in islice(combinations(varied), _MOST_ROBOTS):
        given = dict(zip((name for name, _ in varied), row, strict=True))
        found = Request.of(root, given, packages).read()
        robot = found.robot
        errors = [_in_words(one) for one in found.diagnostics if one.severity == ERROR]
        made[tuple(f"{one}:={value}" for one, value in given.items())] = robot if robot and not errors else errors[0]
    return made


def _in_words(problem: Diagnostic) -> str:
    span = problem.span
    return f"{problem.message} ({Path(span.source.path).name}:{span.line})" if span else problem.message


def _other(before: Mapping[tuple[str, ...], Robot | str], after: Mapping[tuple[str, ...], Robot | str]) -> str:
    for row, robot in before.items():
        again = after.get(row)
        how = f" (with {' '.join(row)})" if row else ""
        if isinstance(robot, str):
            return f"cannot be compared, since it does not compile: {robot}{how}"
        if not isinstance(again, type(robot)):
            return f"does not compile any more: {again or next(iter(after.values()))}{how}"
        if again != robot:
            first = model_differences(robot, again)[:1]
            return f"is another robot: {' '.join(first)}{how}"
    return ""
