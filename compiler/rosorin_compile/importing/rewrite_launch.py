"""Find the lines of launch and CMake files that expand a xacro, and rewrite them to compile the description.

The files of the package and of the packages next to it are read, and never changed.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Set
from contextlib import suppress
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
_COMMENTS = ("#", "<!--", '"""', "'''")
_ARGUMENT = re.compile(r"([A-Za-z_]\w*):=")
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
    """A line to change: its file relative to the package, its number, and the old and the new text.

    ``new`` is empty if a person has to write it; ``remark`` has the reason.
    """

    file: str
    number: int
    old: str
    new: str
    remark: str = ""


def lines_to_change(package: Path, source: str, description: str, arguments: Set[str]) -> list[Line]:
    """Return the lines that expand a source of a package; ``arguments`` are those of the description."""
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
    """Yield the launch files and CMakeLists.txt of a package, then those of the packages next to it."""
    own = files.resolve(package)
    others: list[Path] = []
    with suppress(OSError):
        others = [one for one in sorted(own.parent.iterdir()) if files.is_file(one / "package.xml") and one != own]
    for folder in [package, *others[:_MOST_PACKAGES]]:
        with suppress(OSError):
            for name in files_below(folder, skip_built=True):
                if is_launch_file(name) or name == "CMakeLists.txt":
                    yield folder / name


def _lines(name: str, text: str, source: str, description: str, arguments: Set[str]) -> Iterator[Line]:
    """Yield the lines of a file that name the source, or call xacro where that can only be for it."""
    file = Path(source).name
    alone = set(_XACRO_FILE.findall(text)) == {file}
    for number, line in enumerate(text.split("\n"), 1):
        bare = line.strip()
        has_name = re.search(rf"(?<![\w.-]){re.escape(file)}", line) is not None
        calls = _MODULE.search(line) is not None or any(form.search(line) for form, _ in _CALLS)
        if bare.startswith(_COMMENTS) or not (has_name or (alone and calls)):
            continue
        new, remark = line, ""
        if _ADD_FILES.search(line):
            new = f"rosorin_compile_add_robot(DESCRIPTION {description} OUTPUTS urdf INSTALL)"
        elif _FIND_PACKAGE.search(line):
            new = "find_package(rosorin_compile_cmake REQUIRED)"
        else:
            new = _renamed(line, source, f"{description}/{Description.ROOT_FILE}") if has_name else line
            if module := _MODULE.search(new):
                new, remark = _without_module(new, module.start())
            else:
                absent = [word for word in _ARGUMENT.findall(new) if word not in arguments]
                new, remark = _called(new)
                if absent:
                    missing = f"the description has no argument {listed(absent)}: leave it out, or add it under args"
                    remark = "; ".join(filter(None, [remark, missing]))
        if new.strip() != bare or remark:
            yield Line(name, number, bare, new.strip(), remark)


def _called(line: str) -> tuple[str, str]:
    """Return a line with the call of xacro as that of this tool, and a remark about what is left to do."""
    for form, instead in _CALLS:
        found = form.search(line)
        if found is not None:
            changed = form.sub(instead, line, count=1)
            made = _with_output(changed, found.start(), len(line) - found.end())
            if made is None:
                return _OLD_FLAGS.sub("", changed), f'the last word of the command is "{OUTPUT}"'
            return _OLD_FLAGS.sub("", made), ""
    return line, ""


def _with_output(line: str, start: int, after: int) -> str | None:
    """Return a line with the output as the last word of a call, or None if the call does not end in the line.

    The call begins at ``start``; ``after`` letters follow the name of the program.
    """
    quote = line[start - 1 : start].strip("([")
    opened = _opened(line, start)
    bracket = "" if opened is None else line[opened]
    inside, quoted, behind = line[len(line) - after :].partition(quote or "\0")
    goes_on = behind.lstrip()[:1] in {"[": ",+", "(": "+"}.get(bracket, "")
    if quoted and not (behind.strip() and goes_on):  # the call is one text
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
    """Return the innermost bracket that is open at a place of a line."""
    brackets = [at for at in range(place) if line[at] in "(["]
    return next((at for at in reversed(brackets) if (_closed(line, at) or place) >= place), None)


def _closed(line: str, opened: int) -> int | None:
    """Return where a bracket of a line is closed, or None if that is in another line."""
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
