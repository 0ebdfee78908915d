"""frames_picture: the tree of frames as a picture (``drawing``); the end of its file name says which kind."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.formats.format import Asked, Format, Importing, Proving
from rosorin_compile.formats.unsupported import NODES, UNPUBLISHED
from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import Diagnostic, did_you_mean, error
from rosorin_compile.source.rule_registry import Heading, Rule

from .drawing import SUFFIXES, picture, suffix

if TYPE_CHECKING:
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.rules.case import Case

    from .drawing.situations import Situation

RULES = (
    Rule(
        "picture-kind",
        "A picture whose file name does not say what kind it is.",
        "End it in `.svg`, `.dot`, `.gv`, `.mmd` or `.md`.",
        Heading.OUTPUTS,
    ),
    Rule(
        "too-many-pictures",
        "The tree of frames differs in more combinations of modes than one picture can show.",
        "Say under `modes` which are on, one picture each.",
        Heading.OUTPUTS,
    ),
)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the picture of a robot. Option ``modes``: the names of those that are on; left out: every situation."""
    from .drawing.situations import TooMany

    try:
        return picture(robot, _kind(output), _asked(robot, output)), []
    except TooMany as problem:
        help = "say which modes are on, one picture each: modes: [NAME, ...]"
        return "", [error("too-many-pictures", str(problem), None, help)]


def _kind(output: Output) -> str:
    """Return the kind of picture: SVG where the file name does not say (in a description the rules refuse that)."""
    return suffix(output.file) or ".svg"


def _asked(robot: Robot, output: Output) -> tuple[Situation, ...]:
    """Return the situations that an output asks for. Raises TooMany."""
    from .drawing.situations import situations

    modes = output.options.get("modes")
    fixed = {} if modes is None else {mode: mode in modes for mode in robot.modes}
    return situations(robot, fixed)


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find a kind of picture that there is not, and modes that do not exist."""
    path: tuple[str, ...] = ("outputs", output.name)
    if not suffix(output.file):
        message = f'"{output.file}" does not say which kind of picture it is'
        help = f"end its name in {', '.join(SUFFIXES)}"
        yield case.problem("picture-kind", message, (*path, "file"), help)
    for index, mode in enumerate(output.options.get("modes", ())):
        if mode not in case.robot.modes:
            message = f'there is no mode "{mode}"'
            help = did_you_mean(mode, case.robot.modes, f'add "{mode}" to modes')
            yield case.problem("unknown-mode", message, (*path, "modes", index), help)


def _syntax(text: str) -> object:
    """Return what a picture consists of; one that is no XML says what it means by its lines."""
    from rosorin_compile.source.xml.elements import canonical, tree_of

    return canonical(tree_of(text)) if text.startswith("<") else text


FORMAT = Format(
    name="frames_picture",
    word="picture of the frames",
    article="a",
    about="the tree of frames, with who publishes each",
    rank=80,
    covers=(
        *NODES,
        *UNPUBLISHED,
        *("robot", "joints.type", "joints.parent", "joints.child", "sensors.type", "sensors.parent", "sensors.frame"),
        *("sensors.joint", "sensors.optical.frame", "sensors.optical.joint", "edges.parent", "edges.child"),
        *("edges.publisher", "edges.moving", "edges.when", "publishers.node"),
    ),
    options={
        "modes": {
            "type": "array",
            "description": "The modes that are on, the others are off; default: a tree for every situation.",
            "items": {"$ref": "#/$defs/name"},
        }
    },
    file="frames.svg",
    endings=tuple(SUFFIXES),
    check=check,
    write=write,
    reading=Importing(
        asked=lambda *source: Asked({"file": "frames.svg"}),  # noqa: ARG005
    ),
    proving=Proving(
        syntax=_syntax,
        shown=False,
    ),
)
