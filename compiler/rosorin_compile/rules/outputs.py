"""Outputs: known formats with the options that they have, each artifact in a file of its own in the outputs folder."""

from __future__ import annotations

import posixpath
from collections.abc import Iterator

from ..diagnostics import NOTE, Diagnostic, did_you_mean
from ..diagnostics.registry import CONTROL, OUTPUTS, rule
from ..diagnostics.wording import first_of
from ..frontend.tree import Path
from ..model import Output
from ..startup import patterns
from .case import Case, exists

AFTER = "poses"

MAX_FOLDERS = 50
_DRIVE = patterns.compile(r"[A-Za-z]:")


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
        if format.check is not None and (not case.wanted or output.name in case.wanted):
            yield from format.check(case, output)


@rule(
    "control-unused",
    "A note: no output asks for the hardware blocks of the description.",
    "`outputs: {urdf: {file: ..., control: jazzy}}`.",
    CONTROL,
)
def hardware(case: Case) -> Iterator[Diagnostic]:
    """Find hardware blocks that go nowhere."""
    if case.robot.control and not any(output.options.get("control") for output in case.robot.outputs):
        message = f"no output asks for the hardware blocks ({first_of([one.name for one in case.robot.control], 3)})"
        help = "in a URDF: control: humble, or jazzy"
        yield case.problem("control-unused", message, ("control",), help, severity=NOTE, key=True)


def _unknown(case: Case, output: Output) -> Diagnostic:
    path: Path = ("outputs", output.name)
    known = [name for name, format in case.formats.items() if format.write is not None]
    named = (*path, "backend")
    at, key = (named, False) if exists(case.tree, named) else (path, True)
    from ..frontend.misnamed import word_meant

    help = word_meant(output.backend, known, "backend")
    if not help.startswith("known"):
        help += f" (known: {', '.join(sorted(known))})"
    elif key:
        help += "; an artifact of your own names its template"
    return case.problem("unknown-backend", f'there is no backend "{output.backend}"', at, help, key=key)


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
            help = "write a relative name with forward slashes, such as rosorin.urdf or urdf/rosorin.urdf"
            yield case.problem("outside-outputs", message, path, help)
            continue
        # Names that differ only in case are one file on the disks of Windows and macOS.
        name = output.file.casefold()
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
