"""Judge: all findings about a recording, the most serious first."""

from __future__ import annotations

from collections.abc import Sequence

from ...diagnostic import Diagnostic
from ...emit import Artifact
from ...registry import RECORDINGS, Rule
from ...wording import first_of
from ..findings import ordered, problem
from ..recording.recording import Recording
from . import edges, joints, sensors, text, tree

RULES = (
    Rule(
        "recording-empty",
        "There is not one message.",
        "Record `/tf`, `/tf_static`, `/joint_states` and `/robot_description`.",
        RECORDINGS,
    ),
    Rule(
        "recording-foreign",
        "There is not one transform.",
        "Record those topics; `--namespace` if they have one.",
        RECORDINGS,
    ),
)


def judge(recording: Recording, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return what is wrong with a recording, held against the description and the compiled artifacts."""
    findings = list(recording.troubles)
    nothing = not (recording.series or recording.rows or recording.asked or recording.refused)
    if (
        nothing
        and (recording.timed or not recording.sensors)
        and not recording.joints.pace.count
        and not recording.descriptions
    ):
        return ordered([*findings, *([] if findings else [_foreign(recording)])])
    findings += edges.edges(recording)
    findings += tree.missing(recording)
    findings += tree.stale(recording)
    findings += tree.late(recording)
    findings += tree.clocks(recording)
    findings += joints.joints(recording)
    findings += joints.robot_description(recording, artifacts)
    findings += sensors.sensors(recording)
    findings += text.rows(recording)
    findings += text.asked(recording)
    if recording.too_many:
        message = f"there are more than {len(recording.series):,} edges; the others were not looked at"
        findings.append(problem("recording-foreign", "the recording", message, "no robot has as many frames"))
    return ordered(findings)


def _foreign(recording: Recording) -> Diagnostic:
    """Return the finding for a recording without a transform."""
    topics = sorted(recording.topics)
    help = "record /tf, /tf_static, /joint_states and /robot_description"
    if recording.messages == 0 and not topics:
        return problem("recording-empty", "the recording", "the recording has no messages", help)
    shown = f": it has {first_of(topics, 6)}" if topics else ""
    namespaced = [topic for topic in topics if topic.endswith("/tf")]
    if namespaced and not recording.description.options.namespace:
        help = f"--namespace {namespaced[0].removesuffix('/tf')} reads {namespaced[0]}"
    return problem("recording-foreign", "the recording", f"the recording has no transforms{shown}", help)
