"""Compare the values ("leaves") in committed, compiled and expected artifacts, under the names of the robot.

To verify an artifact, its expected contents are compared with the values read back from its text. A renamed link or
joint hides no other change, because the old leaves are renamed, too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.language.annotations import misfits
from rosorin_compile.model import Output, Robot, Shape
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.load import json_of
from rosorin_compile.source.progress import Progress

from .describe import Describer
from .names import Names, links_of, new_joint_names, new_link_names, with_names
from .precision import NOISE, POSE_NOISE, Precision, exact, printed_precision, rounding_precision
from .walk import Leaves, Shapes, compare_leaves, leaves

_HELP = "a template or a format is at fault, not the description: please report it"


class Pair(NamedTuple):
    """An artifact: its output, and the leaves of its committed and its compiled text."""

    output: Output
    old: Leaves  # with new names of links and joints
    new: Leaves
    precisions: tuple[Precision, Precision]
    renamed: Mapping[str, Names] = {}  # new names by old names, by kind ("link", "joint")

    @property
    def name(self) -> str:
        """The name of the output."""
        return self.output.name


def output_of(robot: Robot, artifact: Artifact) -> Output:
    """Return the output of a robot for which an artifact was written."""
    unnamed = Output(artifact.output, artifact.backend, artifact.file)
    return next((output for output in robot.outputs if output.name == artifact.output), unnamed)


def pair_of(robot: Robot, artifact: Artifact, committed: str) -> Pair | None:
    """Read old and new leaves of an artifact, or None without a reader for its format. Raises ValueError if damaged."""
    format, output = FORMATS[artifact.backend], output_of(robot, artifact)
    if format.read is None:
        return None
    try:
        old = leaves(format.read(committed))
    except (ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise ValueError(str(problem)) from None
    before, least = printed_precision(committed), rounding_precision(*format.rounding)
    known = lambda key, *values: max(least(key, *values), before(key, *values))  # noqa: E731
    if format.view is not None and not format.partial:
        new, precision = leaves(format.view(robot, output)), least
    else:
        new, precision = leaves(format.read(artifact.text)), printed_precision(artifact.text)
    old, new = under_names(format, output, old), under_names(format, output, new)
    return Pair(output, old, new, (known, precision))


def under_names(format: Format, output: Output, found: Leaves) -> Leaves:
    """Rename leaves to the link names of the robot if an artifact uses different names."""
    names = format.names(output) if format.names is not None else {}
    return with_names(found, names, "link", {})


def with_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Return the pairs after giving links and joints in the old leaves their new names."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= new_link_names(pair.old, pair.new)
    made = []
    for pair in pairs:
        before, after = links_of(pair.old), links_of(pair.new)
        known = {old: new for old, new in links.items() if old in before - after and new in after - before}
        found = with_names(pair.old, known, "link", pair.new)
        joints = new_joint_names(found, pair.new)
        found = with_names(found, joints, "joint", pair.new)
        made.append(pair._replace(old=found, renamed={"link": known, "joint": joints}))
    return made


def agreement(robot: Robot, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Read compiled artifacts back and return an error for each value that differs from the robot."""
    found: list[str] = []
    for number, artifact in enumerate(artifacts):
        Progress.step(f"proving {artifact.file},", number, len(artifacts))
        found += disagreements(robot, artifact)
    return [error("artifacts-disagree", text, None, _HELP) for text in found]


def disagreements(robot: Robot, artifact: Artifact) -> Iterator[str]:
    """Read an artifact back and yield a sentence for each value that differs from the robot."""
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
    precisions = exact, exact
    if output.options.get("number_format") != "exact":
        precisions = rounding_precision(*format.rounding), printed_precision(artifact.text)
    sides = meant, found
    differences = compare_leaves(*sides, precisions, POSE_NOISE if format.partial else NOISE)
    for _, text in Describer(robot, sides, precisions).describe(differences):
        yield f"{artifact.file} differs from what it has to contain: {text}"


def _part(found: Mapping[str, Any], meant: Mapping[str, Any]) -> dict[str, Any]:
    """Return the leaves that the partial view ``meant`` also has; shapes without names and colours."""
    part = {quantity: value for quantity, value in found.items() if quantity in meant}
    for quantity, value in part.items():
        if isinstance(value, Shapes):
            part[quantity] = Shapes(tuple(Shape(shape.geometry, shape.pose) for shape in value.shapes))
    return part
