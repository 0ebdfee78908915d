"""Judging joints and the description that the robot ran with: /joint_states and /robot_description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from ...compare import compare
from ...compare.words import amount
from ...diagnostic import NOTE, WARNING, Diagnostic, did_you_mean
from ...emit import Artifact, feeds
from ...model import ROBOT_STATE_PUBLISHER
from ...registry import RECORDINGS, Rule
from ...wording import and_more, counted, first_of
from ..findings import problem, share
from ..recording.joints import JointLog, Range
from ..recording.recording import Recording
from .edges import leaps_text

RULES = (
    Rule(
        "not-compared",
        "A note: something could not be compared, because a pose or the joint states are not known. An error if "
        "nothing else was there.",
        "`--pose NAME`; record `/joint_states`.",
        RECORDINGS,
    ),
    Rule(
        "joint-state-unknown",
        "`/joint_states` names a joint that is not described.",
        "Correct the driver, or the description.",
        RECORDINGS,
    ),
    Rule(
        "joint-state-missing",
        "`/joint_states` leaves out a joint that robot_state_publisher moves.",
        "Correct the driver.",
        RECORDINGS,
    ),
    Rule("joint-state-short", "A joint state has fewer positions than names.", "Correct the driver.", RECORDINGS),
    Rule(
        "joint-states-two-values",
        "Two nodes publish joint states of the same joints.",
        "Stop one of them.",
        RECORDINGS,
    ),
    Rule("joint-not-a-number", "A position is NaN or infinite.", "Mend the driver.", RECORDINGS),
    Rule(
        "joint-beyond-limit",
        "A warning: a joint was beyond its limits.",
        "Correct the limits, the zero of the servo, or what drives it there.",
        RECORDINGS,
    ),
    Rule(
        "other-robot-description",
        "`/robot_description` is another robot than the compiled URDF.",
        "Deploy what is compiled.",
        RECORDINGS,
    ),
    Rule(
        "robot-description-text",
        "A note: it means the same, in another text.",
        "Deploy what is compiled.",
        RECORDINGS,
    ),
    Rule(
        "robot-description-changed",
        "A warning: there was more than one while the robot ran.",
        "Start one robot_state_publisher, with one URDF.",
        RECORDINGS,
    ),
)

_SHOWN, _FEW = 8, 3
_TOPIC = "/joint_states"


def joints(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the joint states, and what could not be compared without them."""
    log = recording.joints
    robot = recording.description.robot
    moving = [series for series in recording.series.values() if not series.constant and series.reference is not None]
    if not log.pace.count:
        if moving:
            message = (
                f"there is no {_TOPIC}: {len(moving)} moving edges were compared only with what their joints can do"
            )
            yield problem("not-compared", _TOPIC, message, f"record {_TOPIC}, too", severity=NOTE)
        return
    yield from _unknown(recording, [name for name in log.names if name not in robot.joint])
    absent = [joint.name for joint in robot.joints if joint.name in recording.description.joint_names - set(log.names)]
    if absent:
        message = f"{_TOPIC} never names {', '.join(absent)}: robot_state_publisher does not publish what hangs on it"
        help = "the driver has to report every joint that robot_state_publisher moves"
        yield problem("joint-state-missing", _TOPIC, message, help, numbers={"joints": absent})
    if log.leaps.two:
        message = f"{_TOPIC} has two values in turns: {leaps_text(log.leaps)}"
        help = "two nodes publish joint states, such as joint_state_publisher beside the driver: stop one"
        yield problem("joint-states-two-values", _TOPIC, message, help)
    if log.too_short:
        message = f"{share(log.too_short, log.pace.count)} messages of {_TOPIC} have fewer positions than names"
        yield problem("joint-state-short", _TOPIC, message, "the driver has to give a position for each name")
    for name, seen in log.ranges.items():
        yield from _range(log, name, seen)
    unmatched = [series for series in moving if series.values.compared and not series.values.by_state]
    if unmatched and len(unmatched) == len(moving):
        message = f"no transform has the stamp of a message of {_TOPIC}: compared only with what the joints can do"
        help = "robot_state_publisher with ignore_timestamp, or another clock, does that"
        yield problem("not-compared", _TOPIC, message, help, severity=NOTE)


def _unknown(recording: Recording, names: Sequence[str]) -> Iterator[Diagnostic]:
    """Yield the joints that are not described: each, or many of them in one finding."""
    for name in names if len(names) <= _FEW else ():
        help = did_you_mean(name, recording.description.joint_names)
        message = f'{_TOPIC} names "{name}", a joint that is not described'
        yield problem("joint-state-unknown", _TOPIC, message, help)
    if len(names) > _FEW:
        shown = first_of([f'"{name}"' for name in names], _SHOWN)
        message = f"{_TOPIC} names {len(names)} joints that are not described: {shown}"
        help = "describe them, or look whether this is the recording of this robot"
        yield problem("joint-state-unknown", _TOPIC, message, help, numbers={"joints": list(names)})


def _range(log: JointLog, name: str, seen: Range) -> Iterator[Diagnostic]:
    if seen.not_numbers:
        message = f"{name} is no number in {share(seen.not_numbers, seen.seen)} messages of {_TOPIC}"
        yield problem("joint-not-a-number", _TOPIC, message, "mend the driver")
    if seen.beyond:
        lower, upper = log.limits(name)
        excess = max(lower - seen.lowest, seen.highest - upper)
        unit = "m" if log.description.robot.joint[name].type == "prismatic" else "rad"
        often, most = share(seen.beyond, seen.seen), amount(excess, unit)
        message = f"{name} is beyond its limits in {often} messages, by {most} at most"
        evidence = [f"seen {_span(seen.lowest, seen.highest)} {unit}, described {_span(lower, upper)} {unit}"]
        help = "correct the limits, the zero of the servo, or what drives it there"
        yield problem(
            "joint-beyond-limit", name, message, help, severity=WARNING, evidence=evidence, numbers={"excess": excess}
        )


def _span(lower: float, upper: float) -> str:
    texts = [f"{value:.6g}" if math.isfinite(value) else "any" for value in (lower, upper)]
    return f"{texts[0]} to {texts[1]}"


def robot_description(recording: Recording, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    """Yield how the URDF that ran differs from the compiled one."""
    compiled = next((one for one in artifacts if feeds(one.backend, ROBOT_STATE_PUBLISHER)), None)
    if not recording.descriptions or compiled is None:
        return
    topic = "/robot_description"
    if len(recording.descriptions) > 1:
        message = f"{topic} carried {len(recording.descriptions)} different robots"
        help = "two robot_state_publishers, or one that was given another URDF while it ran"
        yield problem("robot-description-changed", topic, message, help, severity=WARNING)
    for ran in recording.descriptions:
        if ran.rstrip() == compiled.text.encode().rstrip():
            continue
        comparison = compare(recording.description.robot, [compiled], {compiled.file: ran})
        evidence = [f"ran -> compiled: {change.line()}" for change in comparison.changes[:_SHOWN]]
        if len(comparison.changes) > _SHOWN:
            evidence.append(f"...{and_more(len(comparison.changes) - _SHOWN)}")
        if comparison.changes:
            many = counted(len(comparison.changes), "difference")
            message = f"{topic} is not the compiled {compiled.file}: {many} of meaning"
            help = "deploy what is compiled, and start robot_state_publisher again"
            yield problem("other-robot-description", topic, message, help, evidence=evidence)
        elif any("damaged" in difference.remark for difference in comparison.texts):
            message = f"{topic} cannot be read as a URDF"
            evidence = [text.remark.partition("(")[2].removesuffix(")") for text in comparison.texts if text.remark]
            yield problem("other-robot-description", topic, message, "look what was given to it", evidence=evidence)
        else:
            message = f"{topic} means what the compiled {compiled.file} means, in another text"
            help = "deploy what is compiled, so that the two stay the same"
            yield problem("robot-description-text", topic, message, help, severity=NOTE)
