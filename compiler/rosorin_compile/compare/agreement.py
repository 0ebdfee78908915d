"""Prove compiled artifacts: what each is meant to contain is compared with what is read back from its text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.language.validator import misfits
from rosorin_compile.model import Robot, Shape
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import WRITING, Rule

from .change import Describer
from .pairs import output_of
from .precision import NOISE, POSE_NOISE, Precision, exact, printed, rounded
from .shape_sentences import shapes_change
from .solids import delta
from .walk import Difference, Leaves, Shapes, compare_leaves, leaves

RULES = (
    Rule(
        "artifacts-disagree",
        "An artifact that was just compiled does not contain what the robot is.",
        "That is a fault of the tool: please report it.",
        WRITING,
    ),
)

_HELP = "a template or a format is at fault, not the description: please report it"


def agreement(robot: Robot, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return an error for each place where a compiled artifact does not contain what it is meant to contain."""
    found: list[str] = []
    for number, artifact in enumerate(artifacts):
        Progress.step(f"proving {artifact.file},", number, len(artifacts))
        found += disagreements(robot, artifact)
    return [error("artifacts-disagree", text, None, _HELP) for text in found]


def disagreements(robot: Robot, artifact: Artifact) -> Iterator[str]:
    """Yield a sentence for each place where an artifact does not contain what it is meant to contain."""
    format = FORMATS[artifact.backend]
    if format.read is None and not format.schema:
        return
    try:
        if format.schema:
            data = (format.data or json_of)(artifact.text)
            for problem in misfits(format.schema, data):
                yield f"{artifact.file} does not fit schemas/{format.schema}.schema.json: {problem}"
        found = leaves(format.read(artifact.text)) if format.read is not None else {}
    except (ValueError, TypeError) as problem:
        yield f"{artifact.file} cannot be read back: {problem}"
        return
    if format.read is None or format.view is None:
        return
    output = output_of(robot, artifact)
    meant = leaves(format.view(robot, output))
    if format.partial:
        found = {thing: _part(found[thing], entry) for thing, entry in meant.items() if thing in found}
    is_exact = output.options.get("number_format") == "exact"
    precisions = (exact, exact) if is_exact else (rounded(*format.rounding), printed(artifact.text))
    sides = meant, found
    differences = compare_leaves(*sides, precisions, POSE_NOISE if format.partial else NOISE)
    for one in differences:
        yield from (
            f"{artifact.file} is not as it is meant to be: {text}" for text in _describe(robot, one, sides, precisions)
        )


def _part(found: Mapping[str, Any], meant: Mapping[str, Any]) -> dict[str, Any]:
    """Return the leaves of a thing that a partial view has, too; shapes without names and looks."""
    part = {quantity: value for quantity, value in found.items() if quantity in meant}
    for quantity, value in part.items():
        if isinstance(value, Shapes):
            part[quantity] = Shapes(tuple(Shape(shape.geometry, shape.pose) for shape in value.shapes))
    return part


def _describe(
    robot: Robot, one: Difference, sides: tuple[Leaves, Leaves], precisions: tuple[Precision, Precision]
) -> Iterator[str]:
    if isinstance(one.old, Shapes) or isinstance(one.new, Shapes):
        pairs = zip((one.old, one.new), precisions, strict=True)
        old, new = (side.solids(precision) if isinstance(side, Shapes) else [] for side, precision in pairs)
        _, link, purpose = one.address
        changed = shapes_change(link, purpose, (len(old), len(new)), delta(old, new))
        yield from map(str, [*changed.numbers, *changed.words])
    else:
        yield str(Describer(robot, sides, precisions).sentence(one))
