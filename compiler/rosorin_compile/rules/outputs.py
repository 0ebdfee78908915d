"""Outputs: known backends with the options that they have, each artifact in a file of its own in the outputs folder."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterator, Mapping

from ..diagnostic import Diagnostic, did_you_mean
from ..emit import BACKENDS
from ..model import Output
from ..registry import OUTPUTS, rule
from ..tree import Path
from .case import Case, exists, suggest

AFTER = "poses"

# What each backend reads of its entry in outputs, beside file and backend.
OPTIONS: Mapping[str, tuple[str, ...]] = {
    "urdf": ("elements", "number_format", "version"),
    "mjcf": ("base", "number_format"),
    "static_tf": ("number_format",),
    "static_tf_json": ("number_format",),
    "robot_model": ("joints", "rename", "servos", "source"),
    "frames": ("number_format",),
    "frames_picture": ("modes",),
    "template": ("options", "template"),
}

# Backends whose numbers are arguments of a program: six could print an exponent, which people do not write there.
_ARGUMENTS = ("static_tf", "static_tf_json")
_DRIVE = re.compile(r"[A-Za-z]:")


@rule(
    "unknown-backend",
    "There is no backend of this name.",
    "Correct it; an artifact of your own needs `template`.",
    OUTPUTS,
)
@rule("unknown-option", "The backend has no such option.", "The message names those it has.", OUTPUTS)
@rule(
    "number-format",
    "`number_format: six` for arguments of static_transform_publisher.",
    "`exact`, or leave it out.",
    OUTPUTS,
)
@rule(
    "picture-kind",
    "A picture whose file name does not say what kind it is.",
    "End it in `.svg`, `.dot`, `.gv`, `.mmd` or `.md`.",
    OUTPUTS,
)
def backends(case: Case) -> Iterator[Diagnostic]:
    """Find outputs of a backend that does not exist, and options that the backend does not have."""
    groups = {group.name for group in case.robot.servos}
    for output in case.robot.outputs:
        path: Path = ("outputs", output.name)
        if output.backend not in BACKENDS:
            said = (*path, "backend")
            at, key = (said, False) if exists(case.tree, said) else (path, True)
            help = did_you_mean(output.backend, BACKENDS)
            if help.startswith("did"):
                help += f" (known: {', '.join(sorted(BACKENDS))})"
            elif key:
                help += "; an artifact of your own names its template"
            yield case.problem("unknown-backend", f'there is no backend "{output.backend}"', at, help, key=key)
            continue
        if output.backend == "frames_picture":
            yield from _picture(case, output)
        if output.backend in _ARGUMENTS and output.options.get("number_format", "exact") != "exact":
            message = f'the backend "{output.backend}" does not print numbers as {output.options["number_format"]}'
            help = "write exact, or leave it out: 7 decimals of metres, 8 of radians"
            yield case.problem("number-format", message, (*path, "number_format"), help)
        known = OPTIONS[output.backend]
        for option in output.options:
            if option not in known:
                message = f'the backend "{output.backend}" has no option "{option}"'
                help = f"its options: {', '.join(known)}"
                yield case.problem("unknown-option", message, (*path, option), help, key=True)
        group = output.options.get("servos")
        if output.backend == "robot_model" and group is not None and group not in groups:
            message = f'there is no servo group "{group}", asked for by output "{output.name}"'
            yield case.problem("unknown-servo", message, (*path, "servos"), suggest(group, groups, "name a group"))


def _picture(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find a kind of picture that there is not, and modes that do not exist."""
    from ..drawing import SUFFIXES, suffix

    path: Path = ("outputs", output.name)
    if not suffix(output.file):
        message = f'"{output.file}" does not say which kind of picture it is'
        help = f"end its name in {', '.join(SUFFIXES)}"
        yield case.problem("picture-kind", message, (*path, "file"), help)
    for index, mode in enumerate(output.options.get("modes", ())):
        if mode not in case.robot.modes:
            message = f'there is no mode "{mode}"'
            help = suggest(mode, case.robot.modes, f'add "{mode}" to modes')
            yield case.problem("unknown-mode", message, (*path, "modes", index), help)


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
    if ".." in parts:
        return "would stand outside the outputs folder"
    if file != posixpath.normpath(file) or not file.strip() or file == ".":
        return "is not the name of a file"
    if any(part.casefold() == ".git" for part in parts) or not file.isprintable():
        return "has a name that no artifact may have"
    return ""
