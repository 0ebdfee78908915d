"""Findings: the rules about recordings, diagnostics that report them, and the wording of their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Help, Related, diagnostic
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.rule_registry import DECLARED, RECORDINGS, declare

# The help of a rule is that of its findings unless they have a better one.
RULES = declare(
    RECORDINGS,
    {
        "recording-unreadable": "The source is not a recording, is damaged, or lacks its end because the recorder was "
        "killed. Fix: See the message; `ros2 bag reindex` or `mcap recover` may help. End a recording with Ctrl-C.",
        "recording-empty": "There are no messages. Fix: Record /tf, /tf_static and /joint_states.",
        "recording-foreign": "There are no transforms. Fix: Record /tf, /tf_static and /joint_states.",
        "recording-type": "A standard topic has another type. Fix: Rename the topic.",
        "recording-other-clock": "A warning, or a note with `/clock`: the recorder had another clock than the stamps, "
        "which ages refer to. Fix: A simulation or a played bag does that; record with --use-sim-time, or set the "
        "clocks of the computers.",
        "recording-silent": "A warning: no messages were recorded for longer than `--stale`. No edge is called stale "
        "for that. Fix: The recorder was paused, the computer stood still, or its clock was set.",
        "recording-no-static": "`/tf_static` has no messages, so that static edges cannot be compared. Fix: Record "
        "/tf_static with durability transient_local, as ros2 bag record does.",
        "text-not-understood": "A text has no known form. Fix: Paste all of it, with its command line.",
        "text-frames": "tf2_echo printed a transform, but the text does not name its frames. Fix: Pass --frames SOURCE "
        "TARGET, or paste the command line above it: ros2 run tf2_ros tf2_echo SOURCE TARGET.",
        "not-compared": "A note: a pose or joint states are missing. An error if nothing could be compared. Fix: "
        "Record /joint_states; for tf2_echo, pass --pose, or paste /joint_states above.",
        "edge-not-described": "A warning: an edge is not described. Fix: Declare it under edges.",
        "edge-wrong-parent": "A frame has another parent than described. Fix: Correct the node.",
        "edge-dropped": "A frame is its own parent, or has no name: tf2 drops it. Fix: Correct the node.",
        "edge-two-parents": "A frame was published under two parents. Fix: Stop one of the nodes.",
        "edge-two-values": "Two nodes publish one edge: a stamp has two values, the edge leaps back and forth, or a "
        "static one changes. Fix: tf2 takes whichever came last: let one node publish it.",
        "edge-published-twice": "A warning: two nodes publish the same values. Fix: Stop one of them.",
        "edge-static-and-moving": "An edge is on `/tf` and `/tf_static`. Fix: Stop one of the nodes.",
        "edge-not-static": "An edge that never moves is on `/tf`. Fix: Publish it on /tf_static.",
        "edge-not-moving": "An edge that moves is on `/tf_static`. Fix: Publish it on /tf.",
        "edge-wrong-value": "A value differs from the description. Fix: Deploy what is compiled.",
        "mounted-backwards": "An edge is turned by a half turn about z. Fix: Deploy what is compiled.",
        "not-a-rotation": "A transform is NaN, or its quaternion not of length 1. Fix: Correct the node.",
        "edge-missing": "No node published an edge that is described. Fix: Look whether its node runs.",
        "edge-of-other-mode": "Some edges are of one mode, others of another. Fix: Set it with --mode.",
        "frames-prefixed": "The frames have another prefix than `--prefix`. Fix: Correct --prefix.",
        "edge-late": "A note: a moving edge was published late. Fix: Start its publisher earlier.",
        "edge-stale": "An edge was older than `--stale`. Fix: Look why its publisher stopped.",
        "stamp-zero": "Messages are stamped with time zero. Fix: A node with use_sim_time receives no /clock, or a "
        "driver does not set the stamp.",
        "stamp-jumps-back": "Stamps jump back by more than 0.1 s. Fix: A clock was set, a simulation or a bag started "
        "again, or two nodes stamp with two clocks.",
        "stamp-other-clock": "Messages are stamped by another clock than the others, a minute or more away. Fix: Set "
        "use_sim_time for all nodes or for none; set the clocks of the computers.",
        "stamp-ahead": "A warning: messages are dated further ahead of their arrival than AMCL does it (1 s). Fix: Set "
        "the clock of the computer, or the parameter that dates ahead (transform_tolerance).",
        "stamp-clock-set": "A warning: the offset between stamps and arrivals changed during the recording. Fix: Set "
        "the clocks of all computers before the nodes start.",
        "joint-state-unknown": "A joint is not described. Fix: Correct the driver, or describe it.",
        "joint-state-missing": "`/joint_states` leaves out a joint. Fix: The driver has to report it.",
        "joint-state-short": "A joint state has fewer positions than names. Fix: Correct the driver.",
        "joint-states-two-values": "Two nodes publish the same joints. Fix: Stop one of them.",
        "joint-not-a-number": "A position is NaN or infinite. Fix: Correct the driver.",
        "joint-beyond-limit": "A warning: a joint was beyond its limits. Fix: Correct them, or the zero.",
        "joint-off-its-leader": "A warning: the reported position of a follower is not the one that its leader gives. "
        "Fix: Correct mimic, or let the driver leave followers out: robot_state_publisher uses reported positions.",
        "other-robot-description": "Another robot than the compiled URDF ran. Fix: Deploy it again.",
        "robot-description-text": "A note: its URDF has another text. Fix: Deploy what is compiled.",
        "robot-description-changed": "A warning: the URDF changed. Fix: Start one publisher.",
        "frame-unknown": "A frame is neither described nor published. Fix: Set frame_id, or describe it.",
        "frame-with-slash": 'tf2 refuses to look up a frame with a leading "/". Fix: Set frame_id.',
        "frame-not-as-declared": "No message has the frame of a sensor. Fix: Set frame_id, or stamps.",
        "frame-late": "A sensor was earlier than its frame. Fix: Wait for the frame.",
        "lookup-fails": "tf2 could not have answered at the exact stamps of messages on arrival: an edge comes too "
        "seldom. Fix: Request the latest transform where things move slowly, wait with a timeout, or publish the edge "
        "more often.",
    },
)

YEAR = 365.25 * 86400.0  # s
_NEAR = math.radians(2.0)  # tolerance within which a turn is called a half turn or a quarter turn
_AXES = ("x", "y", "z")
_WEIGHT = {ERROR: 0, WARNING: 1, NOTE: 2}


def problem(
    rule: str, subject: str, message: str, help: Help = "", evidence: Iterable[str] = (), severity: str = ""
) -> Diagnostic:
    """Return a finding about a subject (an edge, topic or joint); ``evidence`` is printed below the message.

    Help and severity are those of the rule unless others are given.
    """
    related, declared = tuple(Related(line, None) for line in evidence), DECLARED[rule]
    usual = declared.help[:1].lower() + declared.help[1:].rstrip(".").replace("`", "")
    return replace(
        diagnostic(rule, severity or declared.severity, message, None, help or usual, related), of=(subject,)
    )


def ordered(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return each finding once, the most serious first, otherwise in the order in which they were found."""
    unique: dict[tuple[object, ...], Diagnostic] = {}
    for finding in findings:
        unique.setdefault((finding.rule, finding.of, finding.message), finding)
    return sorted(unique.values(), key=lambda finding: _WEIGHT[finding.severity])


def seconds(value: float) -> str:
    """Return a time in s, ms or years with at most three digits.

    >>> seconds(12.34), seconds(0.0981), seconds(0.0021), seconds(1.79e9)
    ('12.3 s', '98 ms', '2.1 ms', '56.7 years')
    """
    if value >= YEAR:
        return f"{value / YEAR:.1f} years"
    if value >= 1:
        return f"{value:.1f} s"
    return f"{value * 1e3:.0f} ms" if value >= 0.01 else f"{value * 1e3:.1f} ms"


def rate_text(rate: float | None) -> str:
    """Return a rate in Hz, or "-" if it is not known."""
    return "-" if rate is None or math.isnan(rate) else f"{rate:.1f} Hz"


def share(part: int, total: int) -> str:
    """Return a part of a total: '12 of 300 (4 %)'."""
    percent = 100 * part / total if total else 0.0
    shown = f"{percent:.0f}" if percent >= 1 or percent == 0 else f"{percent:.1g}"
    return f"{part:,} of {total:,} ({shown} %)"


def pose_text(transform: Transform) -> str:
    """Return a transform as metres and degrees."""
    xyz = " ".join(_short(value, 6) for value in transform.xyz)
    rpy = " ".join(_short(math.degrees(value), 3) for value in transform.rpy())
    return f"{xyz} m, {rpy} deg"


def _short(value: float, digits: int) -> str:
    if not abs(value) < 1e6:
        return f"{value:.6g}"
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def difference(described: Transform, recorded: Transform) -> tuple[float, float, str]:
    """Return the distance between two transforms in metres and radians, and the difference in words.

    Moves are along the axes of the parent, turns about the axes of the described child.
    """
    move = [b - a for a, b in zip(described.xyz, recorded.xyz, strict=True)]
    axis, angle = described.turn_to(recorded)
    far = math.hypot(*move)
    parts = []
    if angle > 1e-7:
        name, degrees = _main_axis(axis), math.degrees(angle)
        shown = f"{degrees:.1f}" if degrees >= 1 else f"{degrees:.2g}"
        if name and abs(angle - math.pi) < _NEAR:
            shown = "180"
        elif name:
            shown = "90" if abs(degrees - 90) < 0.05 else shown
            shown = f"-{shown}" if axis[_AXES.index(name)] < 0 else shown
        parts.append(f"turned by {shown} deg about {name or f'({_joined(axis)})'}")
    if far > 1e-7:
        steps = [(name, step) for name, step in zip(_AXES, move, strict=True) if abs(step) > 0.02 * far]
        words = (f"{'-' if step < 0 else '+'}{amount(abs(step), 'm')} in {name}" for name, step in steps)
        parts.append(f"moved by {', '.join(words)}")
    return far, angle, " and ".join(parts)


def _joined(axis: Vector) -> str:
    return ", ".join(_short(value, 2) for value in axis)


def value_rule(described: Transform, recorded: Transform) -> str:
    """Return the rule for a wrong value: a half turn about z is a sensor mounted backwards."""
    axis, angle = described.turn_to(recorded)
    backwards = abs(angle - math.pi) <= _NEAR and _main_axis(axis) == "z"
    return "mounted-backwards" if backwards else "edge-wrong-value"


def _main_axis(axis: Vector) -> str:
    """Return "x", "y" or "z" for a unit vector within 4 degrees of that axis, otherwise an empty string."""
    largest = max(range(3), key=lambda at: abs(axis[at]))
    return _AXES[largest] if abs(axis[largest]) > math.cos(2 * _NEAR) else ""
