"""Artifacts as they were and as they are: their leaves, under the names of the robot.

A new name of a link or a joint hides nothing else that changed: old leaves get the new names.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.model import Output, Robot

from .names import Names, links_of, new_joint_names, new_link_names, with_joint_names, with_link_names
from .precision import Precision, printed, rounded
from .walk import Leaves, leaves


class Pair(NamedTuple):
    """One artifact: its output, and the leaves of the committed and of the compiled text.

    ``renamed`` are the new names by those of before, by the kind of thing ("link", "joint"): ``old`` has the new ones.
    """

    output: Output
    old: Leaves
    new: Leaves
    precisions: tuple[Precision, Precision]
    renamed: Mapping[str, Names] = {}

    @property
    def name(self) -> str:
        """The name of the output."""
        return self.output.name


def output_of(robot: Robot, artifact: Artifact) -> Output:
    """Return the output of a robot that an artifact was written for."""
    unnamed = Output(artifact.output, artifact.backend, artifact.file)
    return next((output for output in robot.outputs if output.name == artifact.output), unnamed)


def pair_of(robot: Robot, artifact: Artifact, committed: str) -> Pair | None:
    """Return an artifact as it was and as it is; None if its format does not read it back.

    Raises ValueError if the committed text is damaged.
    """
    format, output = FORMATS[artifact.backend], output_of(robot, artifact)
    if format.read is None:
        return None
    try:
        old = leaves(format.read(committed))
    except (ValueError, TypeError, OverflowError, RecursionError) as problem:
        raise ValueError(str(problem)) from None
    before, least = printed(committed), rounded(*format.rounding)
    known = lambda key, *values: max(least(key, *values), before(key, *values))  # noqa: E731
    if format.view is not None and not format.partial:
        new, precision = leaves(format.view(robot, output)), least
    else:
        new, precision = leaves(format.read(artifact.text)), printed(artifact.text)
    old, new = under_names(format, output, old), under_names(format, output, new)
    return Pair(output, old, new, (known, precision))


def under_names(format: Format, output: Output, found: Leaves) -> Leaves:
    """Return leaves under the names that the robot has for links, where an artifact has others."""
    names = format.names(output) if format.names is not None else {}
    return with_link_names(found, names, {})


def with_new_names(pairs: Sequence[Pair]) -> list[Pair]:
    """Return artifacts with the new names of links and joints in what was."""
    links: dict[str, str] = {}
    for pair in pairs:
        links |= new_link_names(pair.old, pair.new)
    return [_renamed(pair, links) for pair in pairs]


def _renamed(pair: Pair, links: Names) -> Pair:
    gone, fresh = links_of(pair.old) - links_of(pair.new), links_of(pair.new) - links_of(pair.old)
    known = {old: new for old, new in links.items() if old in gone and new in fresh}
    old = with_link_names(pair.old, known, pair.new)
    joints = new_joint_names(old, pair.new)
    renamed = {kind: names for kind, names in (("link", known), ("joint", joints)) if names}
    return pair._replace(old=with_joint_names(old, joints, pair.new), renamed=renamed)
