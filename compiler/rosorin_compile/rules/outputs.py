"""Rules about outputs: formats, options, and names of files in the outputs folder."""

import posixpath
import re
import unicodedata
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.language.suggestions import word_meant
from rosorin_compile.model import Output
from rosorin_compile.source.diagnostics import Diagnostic, Suggestion
from rosorin_compile.source.rule_registry import OUTPUTS, rule
from rosorin_compile.source.tree import Path, exists
from rosorin_compile.source.wording import suggest, swaps

from .case import Case

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

MAX_FOLDERS = 50
# File extensions that identify the language of a file, and alternatives that are valid for some of them.
_ENDINGS = {".json", ".svg", ".csv", ".toml", ".pdf", ".png", ".py", ".md", ".yaml", ".yml", ".html", ".htm"}
_ENDINGS |= {".xml", ".urdf", ".xacro", ".sdf"}
_ALSO = {".json": (".yaml", ".yml"), ".yaml": (".yml",), ".html": (".htm",), ".urdf": (".xml", ".xacro")}
_ALSO |= dict.fromkeys((".svg", ".sdf", ".srdf"), (".xml",))
_DRIVE = re.compile(r"[A-Za-z]:")


@rule("unknown-backend", "There is no backend of this name.", "Correct it, or use `template`.", OUTPUTS)
@rule("unknown-option", "The backend has no such option.", "The message names those it has.", OUTPUTS)
def backends(case: Case) -> Iterator[Diagnostic]:
    """Report unknown formats and options, and the problems that the checks of each format find."""
    is_placed = all(any(joint.axis) for joint in case.robot.joints if joint.moves)  # computing poses requires axes
    for output in case.robot.outputs:
        format = case.formats.get(output.backend)
        if format is None or format.write is None:
            yield _unknown(case, output)
            continue
        for option in (option for option in output.options if option not in format.options):
            message = f'format "{output.backend}" of output "{output.name}" has no option "{option}"'
            help = Suggestion(option, format.options, instead=f"known: {', '.join(sorted(format.options))}")
            yield case.problem("unknown-option", message, ("outputs", output.name, option), help, key=True)
        if is_placed and format.check is not None and (not case.wanted or output.name in case.wanted):
            yield from format.check(case, output)


def _unknown(case: Case, output: Output) -> Diagnostic:
    path: Path = ("outputs", output.name)
    for option in output.options:
        if "backend" in swaps(option):
            message, help = f'output "{output.name}" has no key "{option}"', suggest("backend")
            return case.problem("unknown-key", message, (*path, option), help, key=True)
    formats = [format for format in case.formats.values() if format.write is not None]
    is_name = not exists(case.tree, (*path, "backend"))  # without ``backend``, the output is named after its format
    endings = (f".{output.backend.casefold()}", posixpath.splitext(output.file)[1].casefold())
    named = [format.name for ending in endings for format in formats if ending in _endings(format)]
    known = f"known: {', '.join(sorted(format.name for format in formats))}; an artifact of your own needs a template"

    def format_help() -> str:
        help = word_meant(output.backend, [format.name for format in formats], "backend")
        if help.startswith("known"):
            help = f'use the format "{named[0]}" for this file' if named else ""
        return f"{help} ({known})" if help else known

    place = path if is_name else (*path, "backend")
    return case.problem("unknown-backend", f'there is no format "{output.backend}"', place, format_help, key=is_name)


def _endings(format: "Format") -> list[str]:
    return [ending for ending in (posixpath.splitext(format.file)[1], *format.endings) if ending]


@rule("file-ending", help="Call it as its readers expect, or write the format of that name.", topic=OUTPUTS)
def file_endings(case: Case) -> Iterator[Diagnostic]:
    """A warning: the file extension of an artifact belongs to another format."""
    for output in (output for output in case.robot.outputs if output.backend in case.formats):
        format = case.formats[output.backend]
        own, (stem, ending) = _endings(format), posixpath.splitext(output.file)
        valid = {*own, *(ending for one in own for ending in _ALSO.get(one, ()))}
        if own and ending.casefold() in _ENDINGS - valid:
            message = f'the file "{output.file}" of output "{output.name}" has the ending of another format'
            usual = format.file[format.file.find(".") :] if "." in format.file else own[0]
            yield case.problem("file-ending", message, ("outputs", output.name, "file"), f'write "file: {stem}{usual}"')


@rule("outside-outputs", "An artifact would be outside its folder.", "Write a relative name.", OUTPUTS)
@rule("duplicate-file", "Two outputs write one file.", "Give each artifact a file of its own.", OUTPUTS)
def output_files(case: Case) -> Iterator[Diagnostic]:
    """Report artifacts outside of the outputs folder, and pairs of artifacts with conflicting paths."""
    taken: dict[str, Output] = {}
    order = list(case.section("outputs"))
    for output in sorted(case.robot.outputs, key=lambda output: order.index(output.name)):
        path: Path = ("outputs", output.name, "file")
        if reason := _outside(output.file):
            usual = case.formats[output.backend].file if output.backend in case.formats else ""
            name = usual.format(case.robot.name) or f"{output.name}.txt"
            help = f'write "file: {name}", relative to the outputs folder (which "-o FOLDER" chooses)'
            yield case.problem("outside-outputs", f'the artifact "{output.file}" {reason}', path, help)
            continue
        # Names that differ only in case or Unicode form are the same file on Windows and macOS.
        name = unicodedata.normalize("NFC", output.file.casefold())
        clash = [one for one in taken if name == one or name.startswith(f"{one}/") or one.startswith(f"{name}/")]
        if clash:
            first = taken[clash[0]]
            why = "are the same file on Windows and macOS" if name == clash[0] else "cannot both exist"
            message = f'write "{first.file}" and "{output.file}", which {why}'
            message = f'both write "{first.file}"' if first.file == output.file else message
            message, related = f'outputs "{first.name}" and "{output.name}" {message}', ("outputs", first.name, "file")
            yield case.problem("duplicate-file", message, path, related=[("also written here", related)])
        taken.setdefault(name, output)


def _outside(file: str) -> str:
    parts = file.split("/")
    reasons = {
        "has an absolute path": file.startswith("/") or _DRIVE.match(file),
        "has a backslash in its path": "\\" in file,
        f"is nested more than {MAX_FOLDERS} folders deep": len(parts) > MAX_FOLDERS,
        "would be outside the outputs folder": ".." in parts,
        "is not a file name": file != posixpath.normpath(file) or not file.strip() or file == ".",
        "has a path that is not allowed for artifacts": ".git" in file.casefold().split("/") or not file.isprintable(),
    }
    return next((reason for reason, applies in reasons.items() if applies), "")
