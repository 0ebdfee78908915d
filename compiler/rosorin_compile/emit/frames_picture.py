"""frames_picture: the tree of frames as a picture; the end of its file name says which kind (see ``drawing``)."""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostic import Diagnostic, error
from ..drawing import picture, suffix
from ..drawing import read as shown_in
from ..drawing.reading import Shown, facts
from ..drawing.situations import Situation, TooMany, situations
from ..model import Output, Robot
from ..registry import OUTPUTS, Rule
from ..templating import Templates
from . import Facts

RULES = (
    Rule(
        "too-many-pictures",
        "The tree of frames differs in more combinations of modes than one picture can show.",
        "Say under `modes` which are on, one picture each.",
        OUTPUTS,
    ),
)


def emit(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the picture of a robot. Option ``modes``: the names of those that are on; left out: every situation."""
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
    modes = output.options.get("modes")
    fixed = {} if modes is None else {mode: mode in modes for mode in robot.modes}
    return situations(robot, fixed)


def read(text: str) -> Facts:
    """Return what a picture says about frames. Raises ValueError if it is damaged."""
    return facts(shown_in(text))


def disagreements(robot: Robot, output: Output, text: str) -> Iterator[str]:
    """Yield what a picture shows otherwise than the model has it. Raises ValueError if it is damaged."""
    shown = shown_in(text)
    meant = _asked(robot, output)
    if [one.label for one in shown] != [one.label for one in meant]:
        yield "it does not show the situations that it should"
        return
    for drawn, situation in zip(shown, meant, strict=True):
        edges = situation.edges
        if _kind(output) != ".svg":
            edges = tuple(row._replace(joint="", kind="") for row in edges)
        yield from _differences(robot, drawn, situation._replace(edges=edges))


def _differences(robot: Robot, drawn: Shown, situation: Situation) -> Iterator[str]:
    """Yield what is wrong with the tree of one situation."""
    where = f" when {situation.label}" if situation.label else ""
    edges = situation.edges
    frames = {link.name for link in robot.links} | {name for row in edges for name in (row.parent, row.child)}
    for frame in sorted(frames.symmetric_difference(drawn.frames)):
        yield f"it should {'' if frame in frames else 'not '}show the frame {frame}{where}"
    for row in sorted(set(edges).symmetric_difference(drawn.edges)):
        joint = f", joint {row.joint} ({row.kind})" if row.joint else ""
        said = f"{row.parent} -> {row.child}, published by {row.who} on {row.topic}{joint}"
        yield f"it should {'' if row in edges else 'not '}show {said}{where}"
