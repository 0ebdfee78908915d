"""Publishing: who publishes the frames of a robot, counted in every combination of modes; told with its frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rosorin_compile.language.expression import ExpressionError
from rosorin_compile.model import Robot
from rosorin_compile.model.joint import UNPUBLISHED
from rosorin_compile.source.wording import listed

from .conditions import MAX_MODES, combinations, holds, modes_in


class Publishing(NamedTuple):
    """What was found in every combination of modes.

    ``published`` are the frames with exactly one publisher in each combination, ``gaps`` those with none in some,
    ``never`` those with none in any; ``wrong`` have several in some or a condition without a meaning, which the rules
    refuse. ``unchecked`` depend on too many modes.
    """

    modes: tuple[str, ...]
    published: tuple[str, ...]
    gaps: tuple[str, ...]
    never: tuple[str, ...]
    wrong: tuple[str, ...]
    unchecked: tuple[str, ...]


def publishing(robot: Robot) -> Publishing:
    """Return what is so about the frames of a robot, by a count in every combination of modes."""
    whens: dict[str, list[str]] = {}
    for joint in (joint for joint in robot.joints if joint.child not in robot.simulated_frames):
        whens.setdefault(joint.child, []).extend([""] if joint.publisher.kind != UNPUBLISHED else [])
    for edge in robot.edges:
        whens.setdefault(edge.child, []).extend([edge.when] if edge.publisher.kind != UNPUBLISHED else [])
    different = dict.fromkeys(map(tuple, whens.values()))  # of thousands of frames a few
    kind_of = {conditions: _kind(robot, conditions) for conditions in different}
    by_kind: dict[str, list[str]] = {}
    for child, conditions in whens.items():
        by_kind.setdefault(kind_of[tuple(conditions)], []).append(child)
    names = [modes_in(robot, conditions) for conditions in different]
    modes = tuple(mode for mode in robot.modes if any(mode in some for some in names))
    kinds = ("published", "gaps", "never", "wrong", "unchecked")
    return Publishing(modes, *(tuple(by_kind.get(kind, ())) for kind in kinds))


def _kind(robot: Robot, conditions: Sequence[str]) -> str:
    """Return what a frame is whose publishers have these conditions."""
    modes = modes_in(robot, conditions)
    if not conditions:
        return "never"
    if len(modes) > MAX_MODES:
        return "unchecked"
    try:
        counts = {sum(holds(when, states) for when in conditions) for states in combinations(modes)}
    except ExpressionError:
        return "wrong"
    if max(counts) > 1:
        return "wrong"
    return "published" if counts == {1} else "gaps" if 1 in counts else "never"


def in_words(found: Publishing) -> str:
    """Return what was found as a paragraph; empty if nothing was to be shown, or it does not hold."""
    if not found.published + found.gaps or found.wrong:
        return ""
    count = len(found.published)
    what = f"each of {count} frames has" if count != 1 else "one frame has"
    sentences = [
        f"{_checked(found.modes)}: {what} one parent and exactly one publisher, and no way leads round in a circle."
    ]
    if found.gaps:
        sentences.append(f"In some of them nobody publishes {listed(found.gaps)}.")
    if found.never:
        sentences.append(f"Nobody ever publishes {listed(found.never)}.")
    if found.unchecked:
        sentences.append(f"Not checked, for too many modes decide: {listed(found.unchecked)}.")
    return " ".join(sentences)


def _checked(modes: tuple[str, ...]) -> str:
    if not modes:
        return "Checked"
    if len(modes) == 1:
        return f"Checked with {modes[0]} on and with it off"
    return f"Checked in all {2 ** len(modes):,} combinations of {listed(modes)}"
