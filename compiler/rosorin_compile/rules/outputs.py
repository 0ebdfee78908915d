"""Outputs: known formats with the options that they have, each artifact in a file of its own in the outputs folder."""

from __future__ import annotations

import posixpath
import re
import unicodedata
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.model import Output
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, did_you_mean, swaps
from rosorin_compile.source.rule_registry import OUTPUTS, rule
from rosorin_compile.source.tree import Path, exists
from rosorin_compile.source.wording import listed

from .case import Case

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

MAX_FOLDERS = 50
# What stands in a file whose name ends so, whoever wrote it.
_HOLDS = {
    ".py": "Python",
    ".json": "JSON",
    ".md": "Markdown",
    ".svg": "SVG",
    ".csv": "CSV",
    ".toml": "TOML",
    ".pdf": "PDF",
    ".png": "PNG",
    **dict.fromkeys((".yaml", ".yml"), "YAML"),
    **dict.fromkeys((".html", ".htm"), "HTML"),
    **dict.fromkeys((".xml", ".urdf", ".xacro", ".sdf", ".world", ".srdf", ".mjcf"), "XML"),
}
_ALSO = {("JSON", "YAML"), ("SVG", "XML")}  # readers of the second take the first
_ANY_XML = ".xml"
_DRIVE = re.compile(r"[A-Za-z]:")


@rule(
    "unknown-backend",
    "There is no backend of this name.",
    "Correct it; an artifact of your own needs `template`.",
    OUTPUTS,
)
@rule("unknown-option", "The backend has no such option.", "The message names those it has.", OUTPUTS)
def backends(case: Case) -> Iterator[Diagnostic]:
    """Find outputs of a format that does not exist, options that it does not have, and what it finds wrong itself.

    What a format finds wrong of an artifact keeps nobody from another one.
    """
    placed = all(any(joint.axis) for joint in case.robot.joints if joint.moves)  # else no pose can be computed
    for output in case.robot.outputs:
        format = case.formats.get(output.backend)
        if format is None or format.write is None:
            yield _unknown(case, output)
            continue
        path: Path = ("outputs", output.name)
        for option in output.options:
            if option not in format.options:
                message = f'the backend "{output.backend}" has no option "{option}"'
                help = did_you_mean(option, format.options)
                known = f"its options: {', '.join(sorted(format.options))}"
                help = f"{help} ({known})" if help.startswith("did") else known
                yield case.problem("unknown-option", message, (*path, option), help, key=True)
        if placed and format.check is not None and (not case.wanted or output.name in case.wanted):
            yield from format.check(case, output)


def _unknown(case: Case, output: Output) -> Diagnostic:
    path: Path = ("outputs", output.name)
    for option in output.options:
        if "backend" in swaps(option):
            message, help = f'output "{output.name}" has no key "{option}"', 'did you mean "backend"?'
            return case.problem("unknown-key", message, (*path, option), help, key=True)
    known = [name for name, format in case.formats.items() if format.write is not None]
    named = (*path, "backend")
    at, key = (named, False) if exists(case.tree, named) else (path, True)
    from rosorin_compile.language.suggestions import word_meant

    help = word_meant(output.backend, known, "backend")
    by_files = _by_files(case, output, key) if help.startswith("known") else ""
    if by_files or not help.startswith("known"):
        help = f"{by_files or help} (known: {', '.join(sorted(known))})"
    elif key:
        help += "; an artifact of your own names its template"
    return case.problem("unknown-backend", f'there is no backend "{output.backend}"', at, help, key=key)


def _by_files(case: Case, output: Output, is_name: bool) -> str:
    """Return the way out where a format is called like the ending of its files, or else by the ending of the file.

    ``is_name``: the name of the output says the format.
    """
    for ending in (f".{output.backend.casefold()}", posixpath.splitext(output.file)[1].casefold()):
        named = [format.name for format in case.formats.values() if format.write and ending in endings_of(format)]
        if len(named) == 1:
            written = f"{named[0]}: {{file: {output.file}}}" if is_name else f"backend: {named[0]}"
            return f'the format of {ending} is called "{named[0]}": write {written}'
        if ending and named:
            return f"{ending} is what {listed(named)} write"
    return ""


def endings_of(format: Format) -> tuple[str, ...]:
    """Return how the names of files of a format end, the usual one first."""
    usual = posixpath.splitext(format.file)[1]
    return tuple(dict.fromkeys((usual, *format.endings))) if usual else format.endings


@rule(
    "file-ending",
    "A warning: the name of an artifact ends as those of another format do.",
    "Call it as its readers expect, or write the format that the name says.",
    OUTPUTS,
)
def file_endings(case: Case) -> Iterator[Diagnostic]:
    """Find artifacts that are called as something else is, which is what their readers would take them for."""
    for output in case.robot.outputs:
        format = case.formats.get(output.backend)
        ending = posixpath.splitext(output.file)[1].casefold()
        own = endings_of(format) if format is not None else ()
        taken = _taken_for(case, format, own[0], ending) if format is not None and own and ending not in own else ""
        if format is None or not taken:
            continue
        holds = _HOLDS.get(own[0], "") if taken in _HOLDS.values() else format.word
        message = f'output "{output.name}" is {holds}, and "{output.file}" is called as {taken} is'
        usual = format.file[format.file.find(".") :] if "." in format.file else own[0]
        others = [one.name for one in case.formats.values() if one.write is not None and ending in endings_of(one)]
        help = f"write file: {posixpath.splitext(output.file)[0]}{usual}"
        help += f"; {ending} is what {listed(others)} write{'s' * (len(others) == 1)}" if others else ""
        yield case.problem("file-ending", message, ("outputs", output.name, "file"), help, severity=WARNING)


def _taken_for(case: Case, format: Format, own: str, ending: str) -> str:
    """Return what a file of a format is taken for by an ending that is none of its own; empty for itself."""
    holds, seen = _HOLDS.get(own, ""), _HOLDS.get(ending, "")
    if holds and seen and holds != seen and (holds, seen) not in _ALSO:
        return seen
    if ending == _ANY_XML or not seen:
        return ""
    others = [one for one in case.formats.values() if ending in one.endings and one.becomes != format.name]
    return others[0].word if others else ""


@rule(
    "outside-outputs",
    "An artifact would stand outside its folder.",
    "A relative name with forward slashes.",
    OUTPUTS,
)
@rule("duplicate-file", "Two outputs write one file.", "Give each a file of its own.", OUTPUTS)
def files(case: Case) -> Iterator[Diagnostic]:
    """Files outside the outputs folder, and two artifacts that cannot both stand there."""
    taken: dict[str, Output] = {}
    order = list(case.tree.get("outputs") or ())
    for output in sorted(case.robot.outputs, key=lambda output: order.index(output.name)):
        path: Path = ("outputs", output.name, "file")
        reason = _outside(output.file)
        if reason:
            message = f'the artifact "{output.file}" {reason}'
            yield case.problem("outside-outputs", message, path, _inside(case, output))
            continue
        # Names that differ only in case or Unicode form are one file on the disks of Windows and macOS.
        name = unicodedata.normalize("NFC", output.file.casefold())
        for other in taken:
            if not (name == other or name.startswith(f"{other}/") or other.startswith(f"{name}/")):
                continue
            first = taken[other]
            both = f'outputs "{first.name}" and "{output.name}"'
            message = f'{both} both write "{output.file}"'
            if output.file != first.file:
                message = f'{both} write "{first.file}" and "{output.file}", which cannot stand side by side'
            related = [case.related("also written here", ("outputs", first.name, "file"))]
            yield case.problem("duplicate-file", message, path, "give each artifact a file of its own", related=related)
            break
        taken.setdefault(name, output)


def _inside(case: Case, output: Output) -> str:
    """Return the way out for a file that is not one in the outputs folder: a name that is."""
    name = output.file.strip().replace("\\", "/").rstrip("/").rsplit("/", 1)[-1].removeprefix(":")
    if _outside(name) or output.file.rstrip().endswith("/"):
        format = case.formats.get(output.backend)
        name = (format.file if format is not None else "").format(case.robot.name) or f"{output.name}.txt"
    return f"write file: {name}, a name within the outputs folder; -o FOLDER says where that is"


def _outside(file: str) -> str:
    """Return why a file name is not one in the outputs folder; empty if it is."""
    if file.startswith("/") or _DRIVE.match(file):
        return "has an absolute name"
    if "\\" in file:
        return "has a backslash in its name"
    parts = file.split("/")
    if len(parts) > MAX_FOLDERS:
        return f"stands in more than {MAX_FOLDERS} folders"
    if ".." in parts:
        return "would stand outside the outputs folder"
    if file != posixpath.normpath(file) or not file.strip() or file == ".":
        return "is not the name of a file"
    if any(part.casefold() == ".git" for part in parts) or not file.isprintable():
        return "has a name that no artifact may have"
    return ""
