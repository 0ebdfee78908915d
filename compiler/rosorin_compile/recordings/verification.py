"""Compare a recording of a running robot with its description."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType

import numpy as np

from rosorin_compile.formats.compiled import emit, emit_published
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import Robot
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import check_modes
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Related, RequestError, did_you_mean, error, has_errors
from rosorin_compile.source.progress import Progress

from .bags import SUFFIXES, Unreadable
from .bags import Progress as Report
from .bags import read as read_bags
from .expected import Description, Options
from .judge import judge
from .pasted import read_text
from .recording import Recording
from .results import Verified, result_of

_MAX_TEXT = 64 << 20
_NO_MODES: Mapping[str, bool] = MappingProxyType({})


def verify_recording(
    request: Request,
    source: str,
    *,
    modes: Mapping[str, bool] = _NO_MODES,
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
    """Compare a recording with a robot; the options are those of ``rosorin_compile.verify``.

    Raises RequestError for a mode, node or pose that the robot does not have, and for invalid times.
    """
    name, understood = request.description.name, request.understand()
    case, path = understood.case, request.description.path
    if case is None:
        return Verified(name, source, diagnostics=tuple(d for d in understood.diagnostics if d.severity == "error"))
    compiled = emit_published(understood, path) if request.is_foreign else emit(understood, path)
    if has_errors(compiled.diagnostics):
        return Verified(name, source, diagnostics=tuple(d for d in compiled.diagnostics if d.severity == "error"))
    for option, value in (("since", since), ("until", until), ("stale", stale)):
        if value is not None and not 0 <= value < 1e9:
            raise RequestError(f"{option}: {value:g} is no time in seconds")
    if since is not None and until is not None and since >= until:
        raise RequestError("since is not before until")
    robot, prefix = case.robot, prefix.removeprefix("/")
    publishers = {joint.publisher.name for joint in robot.joints} | {edge.publisher.name for edge in robot.edges}
    poses = {one.name: one.positions for one in robot.poses}
    for node in without:
        if node not in publishers:
            raise RequestError(f'{robot.name} has no publisher "{node}"; {did_you_mean(node, publishers - {""})}')
    if pose and pose not in poses:
        raise RequestError(f'{robot.name} has no pose "{pose}"; {did_you_mean(pose, poses) or "it has none"}')
    known, nodes, positions = dict(check_modes(robot, modes)), frozenset(without), poses[pose] if pose else None
    options = Options(known, nodes, positions, frames, since, until, namespace, prefix, stale)
    progress = partial(Progress.step, "reading messages")
    try:
        return verify(robot, compiled.artifacts, source, options, progress, standard_input, case)
    except Unreadable as problem:
        return Verified(name, source, diagnostics=(error("recording-unreadable", str(problem), None, problem.help),))


def verify(
    robot: Robot,
    artifacts: Sequence[Artifact],
    source: str,
    options: Options,
    progress: Report = lambda done, count: None,  # noqa: ARG005
    standard_input: Callable[[], bytes] = lambda: b"",
    case: Case | None = None,
) -> Verified:
    """Compare a recording with a robot and its compiled artifacts; ``case`` has the places of its description.

    ``source`` is a rosbag2 folder, one of its files, a text file, or "-" for text on standard input. Raises Unreadable.
    """
    description = Description(robot, options)
    with np.errstate(all="ignore"):  # a recording may contain any number
        if source == "-":
            recording = _read_text(description, standard_input(), "standard input")
        else:
            recording = _read_path(description, Path(source), progress)
        findings, edges = judge(recording, artifacts), {edge.name: edge for edge in description.edges}
        for number, finding in enumerate(findings):
            if case is not None and (edge := edges.get(finding.of[0])):  # about an edge, also to where it is defined
                path = edge.place if edge.joint is None else case.places.get(("joint", edge.joint.name), ())
                place = Related("described here", case.tree.locate(path, key=True).span)
                findings[number] = replace(finding, related=(*finding.related, place))
        return result_of(recording, findings, source)


def _read_path(description: Description, path: Path, progress: Report) -> Recording:
    try:
        if files.is_folder(path):
            recording = Recording(description, f"rosbag2 folder {path}", complete=True, timed=True)
            read_bags(_bags(path), recording, progress)
            return recording
        special = files.is_special(path)
        if special and not path.is_relative_to("/dev/fd"):
            raise Unreadable(f"{path} is not a regular file", "write it to a file first, or name - for standard input")
        if path.suffix in SUFFIXES:
            recording = Recording(description, str(path), complete=True, timed=True)
            read_bags([path], recording, progress)
            return recording
        with path.open("rb") if special else files.open_binary(path) as file:  # special: a pipe of the shell, <(...)
            return _read_text(description, file.read(_MAX_TEXT + 1), str(path))
    except FileNotFoundError:
        help = "name a rosbag2 folder, a .mcap or .db3 file, a text file, or -"
        raise Unreadable(f"there is no {path}", help) from None
    except OSError as problem:
        raise Unreadable(f"{path} cannot be read: {problem.strerror}") from None


def _bags(folder: Path) -> list[Path]:
    """Return the folder for rosbags to read, or its files if it has no metadata.yaml. Raises Unreadable."""
    if files.is_file(folder / "metadata.yaml"):
        return [folder]
    if bags := [path for path in sorted(folder.iterdir()) if path.suffix in SUFFIXES and files.is_file(path)]:
        return bags
    if inner := [path.parent.name for path in sorted(folder.glob("*/metadata.yaml"))]:
        raise Unreadable(f"{folder} holds several recordings: {', '.join(inner[:5])}", "name one of them")
    message = f"{folder} is no recording: it has no metadata.yaml, no .mcap and no .db3"
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
