"""Compare recordings of a running robot with its description.

``bags`` and ``tf2_echo_text`` read messages into a ``Recording``. ``expected_edges`` lists the transforms (edges) in
the description. ``judge`` and ``judge_edges`` compare the recording with these edges; ``results`` formats the findings.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.source.diagnostics import MissingPackages
from rosorin_compile.source.system import pip_install

if TYPE_CHECKING:
    from rosorin_compile.recordings.results import Verification


def verify(
    robot: FilePath | Request,
    source: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    modes: Mapping[str, bool] | None = None,
    without: Sequence[str] = (),
    pose: str = "",
    frames: tuple[str, str] | None = None,
    since: float | None = None,
    until: float | None = None,
    stale: float = 1.0,
    namespace: str = "",
    prefix: str = "",
    trust: bool = False,
) -> Verification:
    """Compare a recording of the running robot with its description, and return the differences as ``findings``.

    Args:
        source: A rosbag2 folder, a .mcap or .db3 file, a file with the output of ``tf2_echo`` or ``view_frames``, or
            ``-`` for such text on standard input.
        modes: Modes that were on (True) or off (False); modes that are not listed are detected.
        without: Names of ROS nodes that were not running.
        pose: The name of the pose that the robot held while ``tf2_echo`` ran.
        frames: The source and target frame given to ``tf2_echo``, if the text does not contain the command line.
        since: Ignore messages before this time, in seconds since the start of the recording.
        until: Ignore messages after this time, in seconds since the start of the recording.
        stale: The age (s) above which a transform is reported as stale.
        namespace: The namespace of the topics, such as ``robot1``.
        prefix: The prefix of the recorded frames, such as ``robot1/``.
    """
    try:
        from rosorin_compile.recordings.expected_edges import Options
        from rosorin_compile.recordings.verification import verify_recording
    except ModuleNotFoundError as problem:
        if problem.name != "numpy":
            raise
        needs = "rosorin-compile verify needs numpy, and rosbags for recordings"
        raise MissingPackages(f"{needs}: {pip_install('verify')}") from None
    options = Options(modes or {}, frozenset(without), None, frames, since, until, namespace, prefix, stale)
    return verify_recording(
        Request.from_arguments(robot, arguments, packages, trust=trust), os.fsdecode(source), options, pose
    )
