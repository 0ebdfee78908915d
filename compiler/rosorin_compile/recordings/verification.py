"""Compare a recording of a running robot with its description."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType

from rosorin_compile.formats.compiled import emit, emit_published
from rosorin_compile.model import Robot
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.conditions import check_modes
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, did_you_mean, error, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule

from .answers import Verified
from .bags import Unreadable
from .expected import Options
from .findings import with_place
from .judge import Verdict
from .machine import as_result
from .sources import verify

RULES = (
    Rule(
        "recording-unreadable",
        "The source is no recording, or it is damaged, or its end is missing because the recorder was killed.",
        "The message says why; `ros2 bag reindex` or `mcap recover` may help. End a recording with Ctrl-C.",
        Heading.RECORDINGS,
    ),
)


NO_MODES: Mapping[str, bool] = MappingProxyType({})


def verify_recording(
    request: Request,
    source: str,
    *,
    modes: Mapping[str, bool] = NO_MODES,
    without: Sequence[str] = (),
    pose: str = "",
    frames: tuple[str, str] | None = None,
    since: float | None = None,
    until: float | None = None,
    namespace: str = "",
    prefix: str = "",
    stale: float = 1.0,
    standard_input: Callable[[], bytes] = lambda: sys.stdin.buffer.read(),
) -> Verified:
    """Compare a recording with a robot.

    ``source`` is a rosbag2 folder, one of its files, a file of text, or "-" for text on standard input. Times are in s.
    Raises RequestError for a mode, node or pose that the robot does not have, and for invalid times.
    """
    name, understood = request.description.name, request.understand()
    case = understood.case
    if case is None:
        errors = tuple(one for one in understood.diagnostics if one.severity == "error")
        return Verified(name, source, diagnostics=errors)
    robot, path = case.robot, request.description.path
    compiled = emit_published(understood, path) if request.is_foreign else emit(understood, path)
    if has_errors(compiled.diagnostics):
        errors = tuple(one for one in compiled.diagnostics if one.severity == "error")
        return Verified(name, source, diagnostics=errors)
    for option, value in (("since", since), ("until", until), ("stale", stale)):
        if value is not None and not 0 <= value < 1e9:
            raise RequestError(f"{option}: {value:g} is no time in seconds")
    if since is not None and until is not None and since >= until:
        raise RequestError("since is not before until")
    options = Options(
        dict(check_modes(robot, modes)),
        _nodes(robot, without),
        _positions(robot, pose),
        frames,
        since,
        until,
        namespace,
        prefix.removeprefix("/"),
        stale,
    )
    progress = partial(Progress.step, "reading messages")
    try:
        verdict = verify(robot, compiled.artifacts, source, options, progress, standard_input)
    except Unreadable as problem:
        return Verified(name, source, diagnostics=(error("recording-unreadable", str(problem), None, problem.help),))
    return as_result(replace(verdict, findings=_placed(verdict, case)), source)


def _nodes(robot: Robot, names: Sequence[str]) -> frozenset[str]:
    publishers = {joint.publisher.name for joint in robot.joints} | {edge.publisher.name for edge in robot.edges}
    for name in names:
        if name not in publishers:
            raise RequestError(f'{robot.name} has no publisher "{name}"; {did_you_mean(name, publishers - {""})}')
    return frozenset(names)


def _positions(robot: Robot, name: str) -> Mapping[str, float] | None:
    if not name:
        return None
    pose = next((pose for pose in robot.poses if pose.name == name), None)
    if pose is None:
        known = [pose.name for pose in robot.poses]
        raise RequestError(f'{robot.name} has no pose "{name}"; {did_you_mean(name, known) or "it has none"}')
    return pose.positions


def _placed(verdict: Verdict, case: Case) -> list[Diagnostic]:
    """Return the findings; one about an edge with the place in the description that defines it."""
    edges = {edge.name: edge for edge in verdict.description.edges}
    found = []
    for finding in verdict.findings:
        edge = edges.get(finding.of[0])
        if edge is not None:
            path = edge.place if edge.joint is None else case.places.get(("joint", edge.joint.name), ())
            finding = with_place(finding, case.tree.locate(path, key=True).span)
        found.append(finding)
    return found
