"""Switching: the lines of launch and CMake files that expand a xacro, and what they are when a description is compiled.

The files of the package are looked through, and those of the packages beside it. They are read, and never changed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Set
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.output.ros_packages import files_below, is_launch_file
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import listed
from rosorin_compile.source.project import Description

PRINT = "rosorin-compile print"
OUTPUT = "urdf"
_LARGEST = 1_000_000  # bytes of a launch file
_MOST_PACKAGES = 200
_MOST_LINES = 20
_XACRO_FILE = re.compile(r"[\w.-]+\.xacro\b")
_FOUND = r"""FindExecutable\(\s*name\s*=\s*(?P<quote>['"])xacro(?P=quote)\s*\)"""
# How xacro is called: a word of a command, found as a program, as a module, by CMake.
_CALLS = (
    (
        re.compile(rf"PathJoinSubstitution\(\s*\[\s*{_FOUND}\s*,?\s*\]\s*\)|{_FOUND.replace('quote', 'other')}"),
        "FindExecutable(name='rosorin-compile'), ' print'",
    ),
    (re.compile(r"\$\(find-exec xacro\)|\$\(find xacro\)/xacro(?:\.py)?"), PRINT),
    (re.compile(r"""(?<=['"(])(?:ros2 run xacro )?xacro(?= )|(?<=command )xacro(?= )"""), PRINT),
    (re.compile(r"""(['"])xacro\1(?=\s*,)"""), r"\1rosorin-compile\1, \1print\1"),
)
_OLD_FLAGS = re.compile(r"\s--(?:inorder|xacro-ns|check-order)\b")
_MODULE = re.compile(r"\bxacro\.(?:process_file|process|parse)\(")
_ADD_FILES = re.compile(r"\bxacro_add_files\s*\(")
_FIND_PACKAGE = re.compile(r"\bfind_package\s*\(\s*xacro\b")


class Line(NamedTuple):
    """A line to change: its file as seen from the package, its number, how it is and how it has to be.

    ``new`` is empty where that is for a person to say; ``remark`` says more.
    """

    file: str
    number: int
    old: str
    new: str
    remark: str = ""


def lines_to_change(package: Path, source: str, description: str, arguments: Set[str]) -> list[Line]:
    """Return the lines that expand a source, seen from the package, and those that name it for that.

    ``arguments`` are those that the description has.
    """
    found: list[Line] = []
    for path in _files(package):
        try:
            if path.stat().st_size > _LARGEST:
                continue
            text = files.read_text(path, errors="replace")
        except OSError:
            continue
        if Path(source).name in text:
            name = Path(os.path.relpath(path, package)).as_posix()
            found += _lines(name, text, source, description, arguments)
    return found[:_MOST_LINES]


def _files(package: Path) -> Iterator[Path]:
    """Yield the launch files and CMakeLists.txt of a package, then those of the packages beside it."""
    others: list[Path] = []
    try:
        own = files.resolve(package)
        beside = sorted(own.parent.iterdir())
        others = [one for one in beside if files.is_file(one / "package.xml") and one != own]
    except OSError:
        pass
    for folder in [package, *others[:_MOST_PACKAGES]]:
        try:
            names = files_below(folder, skip_built=True)
        except OSError:
            continue
        yield from (folder / name for name in names if is_launch_file(name) or name == "CMakeLists.txt")


def _lines(name: str, text: str, source: str, description: str, arguments: Set[str]) -> Iterator[Line]:
    """Yield the lines of a file that name the source, or call xacro where that can only be for it."""
    file = Path(source).name
    alone = set(_XACRO_FILE.findall(text)) == {file}
    for number, line in enumerate(text.split("\n"), 1):
        bare = line.strip()
        mine = re.search(rf"(?<![\w.-]){re.escape(file)}", line) is not None
        if _is_comment(bare) or not (mine or (alone and _calls(line))):
            continue
        if _ADD_FILES.search(line):
            folder = description
            yield Line(name, number, bare, f"rosorin_compile_add_robot(DESCRIPTION {folder} OUTPUTS urdf INSTALL)")
            continue
        if _FIND_PACKAGE.search(line):
            yield Line(name, number, bare, "find_package(rosorin_compile_cmake REQUIRED)")
            continue
        new = _renamed(line, source, f"{description}/{Description.ROOT_FILE}") if mine else line
        module = _MODULE.search(new)
        if module:
            new, remark = _without_module(new, module.start())
        else:
            (new, unfinished), absent = _called(new), _not_taken(new, arguments)
            remark = "; ".join(filter(None, [unfinished, absent]))
        if new.strip() != bare or remark:
            yield Line(name, number, bare, new.strip(), remark)


_GIVEN = re.compile(r"([A-Za-z_]\w*):=")


def _not_taken(line: str, arguments: Set[str]) -> str:
    """Return which arguments of a line the description does not have, in words; empty if it has all of them."""
    absent = [name for name in _GIVEN.findall(line) if name not in arguments]
    return f"the description has no argument {listed(absent)}: leave it out, or add it under args" if absent else ""


def _is_comment(line: str) -> bool:
    return line.startswith(("#", "<!--", '"""', "'''"))


def _calls(line: str) -> bool:
    return any(form.search(line) for form, _ in _CALLS) or _MODULE.search(line) is not None


def _called(line: str) -> tuple[str, str]:
    """Return a line with the call of xacro as that of this tool, and what is left to be done."""
    for form, instead in _CALLS:
        found = form.search(line)
        if found is not None:
            changed = form.sub(instead, line, count=1)
            asked = _asked(changed, found.start(), len(line) - found.end())
            if asked is None:
                return _OLD_FLAGS.sub("", changed), f'the last word of the command is "{OUTPUT}"'
            return _OLD_FLAGS.sub("", asked), ""
    return line, ""


def _asked(line: str, start: int, after: int) -> str | None:
    """Return a line with the output as the last word of a call; None if the call does not end in the line.

    The call begins at ``start``; ``after`` letters follow the name of the program.
    """
    quote = line[start - 1 : start].strip("([")
    opened = _opened(line, start)
    bracket = "" if opened is None else line[opened]
    inside, quoted, behind = line[len(line) - after :].partition(quote or "\0")
    goes_on = behind.lstrip()[:1] in {"[": ",+", "(": "+"}.get(bracket, "")
    if quoted and not (behind.strip() and goes_on):  # the whole call is one text
        end = len(line) - after + len(inside)
        return f"{line[:end]} {OUTPUT}{line[end:]}"
    closed = None if opened is None else _closed(line, opened)
    if closed is None:
        return None
    program = re.search(r"""(['"])rosorin-compile\1,""", line)
    mark = program[1] if program else quote or ("'" if bracket == "[" else "")
    word = f"{mark}{OUTPUT if program else f' {OUTPUT}'}{mark}"
    between = ", " if bracket == "[" else " + " if mark else ""
    return f"{line[:closed]}{between}{word}{line[closed:]}"


def _opened(line: str, place: int) -> int | None:
    """Return the bracket that is open at a place of a line."""
    opened: list[int] = []
    for at, letter in enumerate(line[:place]):
        if letter in "([":
            opened.append(at)
        elif letter in ")]" and opened:
            opened.pop()
    return opened[-1] if opened else None


def _closed(line: str, opened: int) -> int | None:
    """Return where a bracket of a line is closed; None if that is in another line."""
    depth = 0
    for place in range(opened, len(line)):
        depth += {"(": 1, "[": 1, ")": -1, "]": -1}.get(line[place], 0)
        if not depth:
            return place
    return None


def _renamed(line: str, source: str, description: str) -> str:
    """Return a line with the path of a source as that of the description, however it is written."""
    if source in line:
        return line.replace(source, description)
    *folders, file = source.split("/")
    for count in range(len(folders), 0, -1):  # the last folders as words of a list, or with the signs of pathlib
        joint = r"(['\"])\s*([,/])\s*(['\"])"
        pattern = joint.join([re.escape(word) for word in [*folders[-count:], file]])
        found = re.search(rf"(?<=['\"]){pattern}(?=['\"])", line)
        if found and count == len(folders):
            quote, sign = found[1], found[2]
            between = f"{quote}, {quote}" if sign == "," else f"{quote} / {quote}"
            return line[: found.start()] + between.join(description.split("/")) + line[found.end() :]
    up = "/".join([*[".."] * len(folders), description])
    return re.sub(rf"(?<![\w.-]){re.escape(file)}", up, line)


def _without_module(line: str, start: int) -> tuple[str, str]:
    """Return a line with a call of the module xacro as one of the program, and what is left to be done."""
    opened = line.index("(", start)
    end = _closed(line, opened)
    if end is None:
        return "", f"xacro is called over several lines: take {PRINT} FILE {OUTPUT}, or rosorin_compile.compile()"
    inside = _first_argument(line[opened + 1 : end])
    rest = re.sub(r"^\.to(?:pretty)?xml\([^()]*\)", "", line[end + 1 :])
    made = f"subprocess.check_output(['rosorin-compile', 'print', {inside}, 'urdf'], text=True)"
    remark = "import subprocess" + ("; it is a text: without .toxml()" if rest == line[end + 1 :] else "")
    if "mappings" in line[opened:end]:
        remark += "; arguments are further words NAME:=VALUE"
    return f"{line[:start]}{made}{rest}", remark


def _first_argument(text: str) -> str:
    depth = 0
    for place, letter in enumerate(text):
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and not depth:
            return text[:place].strip()
    return text.strip()
