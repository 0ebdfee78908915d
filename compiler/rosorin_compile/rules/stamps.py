"""Stamps: every frame that a message names in its header exists, and tf2 knows it in every mode."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import FRAMES, rule
from rosorin_compile.source.tree import Path, exists

from . import conditions
from .case import Case
from .tf_tree import Step, active_in, is_tree, legal_steps, silences


class Stamp(NamedTuple):
    """A frame that messages are stamped with, by whom, and where that is said; ``said`` is False for a default."""

    frame: str
    who: str
    path: Path
    said: bool


def stamps(case: Case) -> Iterator[Stamp]:
    """Yield the frames that sensors and other nodes stamp, in the order of the description."""
    for sensor in case.robot.sensors:
        path: Path = ("sensors", sensor.name)
        declared = exists(case.tree, (*path, "stamps"))
        for index, frame in enumerate(sensor.stamps):
            own = (*path, "frame") if index == 0 else (*path, "optical", "frame")
            yield Stamp(frame, f'sensor "{sensor.name}"', (*path, "stamps", index) if declared else own, declared)
    for name, entry in (case.tree.get("publishers") or {}).items():
        for index, frame in enumerate((entry or {}).get("stamps", ())):
            yield Stamp(frame, f'publisher "{name}"', ("publishers", name, "stamps", index), True)


@rule(
    "unknown-frame-id",
    "Messages are stamped with a frame that does not exist. As a warning: tf2 does not know it, always or in some "
    "mode.",
    "Correct the name under `stamps`, or say who publishes the frame.",
    FRAMES,
)
def unknown_frames(case: Case) -> Iterator[Diagnostic]:
    """Frames in the headers of messages that do not exist, or that tf2 does not know, always or in some mode.

    A frame that somebody publishes in another mode is a gap, which is said; but not where the description has nobody
    publish it in that mode.
    """
    robot, stamped = case.robot, list(stamps(case))
    if not stamped:
        return
    frames = {*robot.link, *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    published, silent = legal_steps(case), silences(case)
    whens = [step.edge.when for step in (*published, *silent) if step.edge]
    modes = conditions.modes_in(robot, whens)
    whole = is_tree(case) and len(modes) <= conditions.MAX_MODES
    told: set[str] = set()
    for stamp in stamped:
        if stamp.frame not in frames:
            message = f'there is no frame "{stamp.frame}", which {stamp.who} stamps its messages with'
            help = case.suggest(stamp.path, stamp.frame, frames, "name a frame of the robot")
            yield case.problem("unknown-frame-id", message, stamp.path, help)
        elif whole and stamp.frame not in told and len(frames) > 1:
            absent = _absent(stamp.frame, conditions.combinations(modes), published)
            if absent and stamp.frame in {step.child for step in published}:
                none = [step for step in silent if step.child == stamp.frame]
                absent = [one for one in absent if active_in(none, one)]
            if absent:
                told.add(stamp.frame)
                always = len(absent) == 2 ** len(modes)
                yield _not_on_tf(case, stamp, {} if always else absent[0], silent)


def _absent(
    frame: str, combinations: Iterable[conditions.Combination], published: list[Step]
) -> list[conditions.Combination]:
    """Return the combinations of modes in which no transform has a frame."""
    return [
        combination
        for combination in combinations
        if not any(frame in (step.parent, step.child) for step in active_in(published, combination))
    ]


def _not_on_tf(case: Case, stamp: Stamp, missing: conditions.Combination, silent: list[Step]) -> Diagnostic:
    """Return what is said of a frame that is not there in a combination of modes; {} is always."""
    when = conditions.in_words(missing)
    message = f'tf2 does not know the frame "{stamp.frame}"{when}, which {stamp.who} stamps its messages with'
    joint = case.robot.joint_to.get(stamp.frame)
    related = []
    if joint is not None and not when:
        related = [case.related(f'nobody publishes joint "{joint.name}"', case.publisher(joint))]
    elif when:
        none = [step for step in active_in(silent, missing) if step.child == stamp.frame]
        related = [case.related("nobody publishes it then, it says here", step.path) for step in none]
    help = "say who publishes it" + (" then" if related and when else "")
    help += "" if stamp.said else ", or what the messages are stamped with: stamps: [FRAME]"
    return case.problem("unknown-frame-id", message, stamp.path, help, related=related, severity=WARNING)
