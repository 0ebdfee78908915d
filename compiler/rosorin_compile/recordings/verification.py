"""Compare a recording of a running robot with its description, and draw the rates and gaps of its messages."""

import itertools
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult, LoadedRobot, emit
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Robot
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import check_modes
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Related, RequestError, UnknownName, error, has_errors
from rosorin_compile.source.wording import mask_controls

from .bags import SUFFIXES, Unreadable
from .bags import read as read_bags
from .expected_edges import Description, ExpectedEdge, Options
from .judge import answer_outcome, judge
from .judge_edges import best_way
from .recording import Recording
from .results import EchoAnswer, Finding, RecordedEdge, RecordedSensor, Verification, rate_text, seconds
from .series import SECOND, SLICES, Pace, Series, Times, slice_width
from .tf2_echo_text import read_text

_Record = TypeVar("_Record")
_MAX_TEXT = 64 << 20
_SHORT = SECOND // 2  # ns: shorter pauses are not drawn as gaps
_LETTERS = 46


def emit_published(understood: LoadedRobot, path: Path) -> CompileResult:
    """Generate the URDF of a robot in another format; the text of a URDF file is returned unchanged."""
    compiled = emit(understood, path)
    if path.suffix.lower() in FORMATS.published_format().endings:
        text = files.read_text(path, errors="replace")
        return replace(compiled, artifacts=tuple(replace(one, text=text) for one in compiled.artifacts))
    return compiled


def verify_recording(request: Request, source: str, options: Options, pose: str = "") -> Verification:
    """Compare a recording with a robot; ``pose`` is the name of its pose while tf2_echo ran, or "" if unknown.

    Raises RequestError if the robot does not have a mode, ROS node or pose, and for invalid times.
    """
    name, understood = request.description.name, request.understand()
    case, path, diagnostics = understood.case, request.description.path, understood.diagnostics
    if case is not None:
        compiled = emit_published(understood, path) if request.is_foreign else emit(understood, path)
        diagnostics = compiled.diagnostics
    if case is None or has_errors(diagnostics):
        return Verification(name, source, diagnostics=tuple(d for d in diagnostics if d.severity == "error"))
    for option in ("since", "until", "stale"):
        if (value := getattr(options, option)) is not None and not 0 <= value < 1e9:
            raise RequestError(f"{option}: {value:g} is not a time in seconds")
    if options.since is not None and options.until is not None and options.since >= options.until:
        raise RequestError("since is not before until")
    robot = case.robot
    publishers = {joint.publisher.name for joint in robot.joints} | {edge.publisher.name for edge in robot.edges}
    poses = {one.name: one.positions for one in robot.poses}
    for node in sorted(options.without - publishers):
        raise UnknownName("publisher", node, publishers - {""}, robot.name, "it has none")
    if pose and pose not in poses:
        raise UnknownName("pose", pose, poses, robot.name, "it has none")
    modes, prefix = dict(check_modes(robot, options.modes)), options.prefix.removeprefix("/")
    options = replace(options, modes=modes, pose=poses.get(pose), prefix=prefix)
    try:
        return verify(robot, compiled.artifacts, source, options, lambda: sys.stdin.buffer.read(), case)
    except Unreadable as problem:
        refusal = error("recording-unreadable", str(problem), None, problem.help)
        return Verification(name, source, diagnostics=(refusal,))


def verify(
    robot: Robot,
    artifacts: Sequence[Artifact],
    source: str,
    options: Options,
    standard_input: Callable[[], bytes] = lambda: b"",
    case: Case | None = None,
) -> Verification:
    """Compare a recording with a robot and its artifacts; ``case`` has the source positions for the findings.

    ``source`` is a rosbag2 folder, one of its files, a text file, or "-" for text on standard input. Raises Unreadable.
    """
    description = Description(robot, options)
    with np.errstate(all="ignore"):  # avoid warnings for recorded inf and nan
        if source == "-":
            recording = _read_text(description, standard_input(), "standard input")
        else:
            recording = _read_path(description, Path(source))
        findings, edges = judge(recording, artifacts), {edge.name: edge for edge in description.edges}
        for number, finding in enumerate(findings):
            if case is not None and (edge := edges.get(finding.of[0])):  # add the position in the YAML
                path = edge.place if edge.joint is None else case.places.get(("joint", edge.joint.name), ())
                place = Related("described here", case.tree.locate(path, key=True).span)
                findings[number] = replace(finding, related=(*finding.related, place))
        return _result(recording, findings, source)


def _read_path(description: Description, path: Path) -> Recording:
    if (special := files.is_special(path)) and not path.is_relative_to("/dev/fd"):
        raise Unreadable(f"{path} is not a regular file", "write it to a file first, or name - for standard input")
    try:
        is_folder = files.is_folder(path)
        if is_folder or path.suffix in SUFFIXES:
            form = f"rosbag2 folder {path}" if is_folder else str(path)
            recording = Recording(description, form, complete=True, timed=True)
            read_bags(_bags(path) if is_folder else [path], recording)
            return recording
        with path.open("rb") if special else files.open_binary(path) as file:  # a pipe, such as <(...) in bash
            return _read_text(description, file.read(_MAX_TEXT + 1), str(path))
    except FileNotFoundError:
        help = "name a rosbag2 folder, a .mcap or .db3 file, a text file, or -"
        raise Unreadable(f"there is no {path}", help) from None
    except OSError as problem:
        raise Unreadable(f"{path} cannot be read: {problem.strerror}") from None


def _bags(folder: Path) -> list[Path]:
    """Return the folder if rosbags can read its metadata.yaml, else the bag files in it. Raises Unreadable."""
    if files.is_file(folder / "metadata.yaml"):
        return [folder]
    if bags := [path for path in sorted(folder.iterdir()) if path.suffix in SUFFIXES and files.is_file(path)]:
        return bags
    if inner := [path.parent.name for path in sorted(folder.glob("*/metadata.yaml"))]:
        raise Unreadable(f"{folder} holds several recordings: {', '.join(inner[:5])}", "name one of them")
    message = f"{folder} is not a recording: it has no metadata.yaml, no .mcap and no .db3"
    raise Unreadable(message, "name a rosbag2 folder")


def _read_text(description: Description, data: bytes, name: str) -> Recording:
    if len(data) > _MAX_TEXT:
        raise Unreadable(f"{name} is larger than any pasted text ({_MAX_TEXT >> 20} MiB)", "record a bag instead")
    if b"\0" in data:
        help = "name a folder, a .mcap, a .db3 or a text"
        raise Unreadable(f"{name} is neither a rosbag2 recording nor a text", help)
    recording = Recording(description, f"text in {name}")
    read_text(data.decode("utf-8", "replace"), recording)
    return recording


def _result(recording: Recording, findings: Sequence[Diagnostic], source: str) -> Verification:
    way, states, sensors = best_way(recording), recording.joints.pace, list[RecordedSensor]()
    has_times = recording.timed and recording.messages
    if states.count:
        kind = "sensor_msgs/msg/JointState"
        sensors = [_copy(RecordedSensor, states, topic="/joint_states", type=kind, frame="-", early=0, lookups=[])]
    sensors += [_copy(RecordedSensor, one, one.pace, lookups=list(one.lookups.values())) for one in recording.uses]
    shown = []
    for one in findings:
        place = next((related.span for related in one.related if related.span is not None), None)
        evidence = [related.message for related in one.related if related.span is None]
        at = (place.source.path, place.line) if place else (None, None)
        shown.append(Finding(one.rule, one.severity, one.of[0], one.message, one.with_help().help, evidence, *at))
    return Verification(
        robot=recording.description.robot.name,
        source=source,
        form=recording.form,
        messages=recording.messages,
        seconds=max(0, recording.end - recording.start) / SECOND if has_times else None,
        modes=dict(way.modes),
        edges=tuple(_edges(recording, {edge.child: edge for edge in way.edges})),
        joints=tuple(recording.joints.reported.values()),
        sensors=tuple(sensors),
        answers=tuple(EchoAnswer(one.name, one.line, answer_outcome(recording, one)) for one in recording.answers),
        findings=tuple(shown),
        as_described=not has_errors(findings),
        diagnostics=tuple(findings),
        data=recording,
    )


def _copy(record: type[_Record], *sources: object, **values: Any) -> _Record:
    """Create a record with fields from ``values`` or else attributes of ``sources``; replace inf and nan with None."""
    for name in (one.name for one in fields(record) if one.name not in values):  # type: ignore[arg-type]
        value = next((getattr(source, name) for source in sources if hasattr(source, name)), None)
        values[name] = None if isinstance(value, float) and not math.isfinite(value) else value
    return record(**values)


def _edges(recording: Recording, described: Mapping[str, ExpectedEdge]) -> Iterator[RecordedEdge]:
    for child in dict.fromkeys([*described, *recording.edges_by_child]):
        edge, owner = described.get(child), ""
        if edge is not None:  # without known modes, any of several nodes may publish the edge
            known = [edge] if recording.description.options.modes else recording.description.by_child[child]
            owner = " or ".join(dict.fromkeys(one.publisher.name for one in known))
        for series in recording.edges_by_child.get(child, ()):
            oldest = series.pace.oldest_until(recording.end).seconds if recording.timed and not series.static else None
            values, value = {"count": None, "mean_age": series.age} if series.listed else {}, _value(series)
            yield _copy(RecordedEdge, series, series.pace, publisher=owner, value=value, oldest=oldest, **values)
        if edge is not None and child not in recording.edges_by_child and recording.complete:
            yield RecordedEdge(edge.parent, child, "", edge.publisher.name, "missing", 0)


def _value(series: Series) -> str:
    if series.edge is None:
        return "not described"
    if series.edge.parent != series.parent:
        return "wrong parent"
    if series.listed:
        return "parent as described"
    if series.bad == series.pace.count:
        return "no rotation"
    if series.wrong:
        return "wrong" if series.wrong == series.compared else f"wrong in {series.wrong:,} of {series.compared:,}"
    if series.by_state:
        return f"as described, {series.by_state:,} by joint state"
    if series.compared:
        return "as its joint can be" if series.edge.moving else "as described"
    return "known only to its publisher"


def as_svg(recording: Recording) -> str:
    """Draw the message rates and gaps of a recording as SVG. Raises ValueError if times of arrival are unknown."""
    # Rows (label, pace, draw gaps); static edges have no gaps, because they are published only once.
    streams = [(series.name, series.pace, True) for series in recording.series.values() if not series.static]
    streams += [("/joint_states", recording.joints.pace, True)] if recording.joints.pace.count else []
    streams += [(f"{use.topic} {use.frame}", use.pace, True) for use in recording.uses]
    streams += [(f"{one.name} (static)", one.pace, False) for one in recording.series.values() if one.static]
    if not recording.timed or not streams:
        raise ValueError("a picture needs a recording that says when messages were received")
    span = max(recording.end - recording.start, 1)
    width = slice_width(span)
    slices = min(SLICES, -(-span // width))
    rows: list[dict[str, Any]] = []
    for label, pace, moves in streams[:80]:
        counts = np.bincount(pace.slices(width), minlength=SLICES)[:slices]
        note = f"{rate_text(pace.rate)}, {seconds(pace.gap.seconds)}"
        label = mask_controls(label if len(label) <= _LETTERS else f"{label[: _LETTERS - 3]}...")
        note = note if moves and pace.count > 1 else f"{pace.count} in all"
        bars = [(at / slices, counts[at] / counts.max()) for at in np.flatnonzero(counts).tolist()]
        rows.append({"label": label, "bars": bars, "note": note, "gaps": _gaps(counts, pace, width) if moves else []})
    title = f"{recording.description.robot.name}: {recording.messages:,} messages in {span / SECOND:.1f} s"
    values = {"title": mask_controls(title), "rows": rows, "step": 1 / slices, "seconds": span / SECOND}
    return Templates.own("recordings/rates.svg.jinja", values)


def _gaps(counts: Times, pace: Pace, width: int) -> list[tuple[float, float]]:
    """Return (start, length) of each pause longer than three mean intervals, as fractions of the plot width."""
    usual = (pace.last - pace.first) / max(1, pace.count - 1)
    edges = [-1, *np.flatnonzero(counts).tolist(), len(counts)]
    spans = [(before + 1, after - before - 1) for before, after in itertools.pairwise(edges)]
    return [(at / len(counts), n / len(counts)) for at, n in spans if n * width > max(3 * usual, _SHORT)]
