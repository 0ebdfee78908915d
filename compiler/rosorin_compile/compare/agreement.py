"""Prove compiled artifacts: what each is meant to contain is compared with what is read back from its text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.language.validator import misfits
from rosorin_compile.model import Robot, Shape
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.load import json_of
from rosorin_compile.source.progress import Progress

from .describe import Describer
from .pairs import output_of
from .precision import NOISE, POSE_NOISE, exact, printed, rounded
from .walk import Shapes, compare_leaves, leaves

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
    for _, text in Describer(robot, sides, precisions).describe(differences):
        yield f"{artifact.file} is not as it is meant to be: {text}"


def _part(found: Mapping[str, Any], meant: Mapping[str, Any]) -> dict[str, Any]:
    """Return the leaves of a thing that a partial view has, too; shapes without names and looks."""
    part = {quantity: value for quantity, value in found.items() if quantity in meant}
    for quantity, value in part.items():
        if isinstance(value, Shapes):
            part[quantity] = Shapes(tuple(Shape(shape.geometry, shape.pose) for shape in value.shapes))
    return part
