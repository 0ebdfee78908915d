"""Forward kinematics of 100,000 joint states of the reference robot, against pinocchio in a loop of Python.

Both place the same frames in base_link: one chain to the camera on the arm, and all frames of the URDF, whose numbers
have six digits. pinocchio is timed twice: the bare loop that computes and keeps nothing, and the loop that keeps each
frame as we do, in arrays. CPU seconds of this process, in pairs.

Run with the environment's Python: ``python benchmarks/kinematics.py [PAIRS]``.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from pairs import compare, row
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model.kinematics import Kinematics

STATES = 100_000
BASE, CAMERA = "base_link", "depth_camera_link"
GOAL = 1.0
ROBOT = Path(__file__).resolve().parent.parent / "descriptions" / "rosorin" / "robot.yaml"

Array = NDArray[np.float64]


class Loop:
    """pinocchio on the compiled URDF: one state after the other."""

    def __init__(self, urdf: str, positions: dict[str, Array]) -> None:
        self.model = pinocchio.buildModelFromXML(urdf)
        self.data = self.model.createData()
        self.q = np.zeros((STATES, self.model.nq))
        for name, values in positions.items():
            self.q[:, self.model.joints[self.model.getJointId(name)].idx_q] = values
        bodies = [i for i, frame in enumerate(self.model.frames) if frame.type == pinocchio.FrameType.BODY]
        self.frames = {self.model.frames[i].name: i for i in bodies}

    def bare_chain(self) -> None:
        model, data, frame = self.model, self.data, self.frames[CAMERA]
        for q in self.q:
            pinocchio.forwardKinematics(model, data, q)
            pinocchio.updateFramePlacement(model, data, frame)

    def bare_all(self) -> None:
        model, data = self.model, self.data
        for q in self.q:
            pinocchio.framesForwardKinematics(model, data, q)

    def kept(self, names: list[str]) -> dict[str, Array]:
        model, data, placements = self.model, self.data, self.data.oMf
        out = {name: np.empty((STATES, 4, 4)) for name in names}
        wanted = [(self.frames[name], made) for name, made in out.items()]
        for state, q in enumerate(self.q):
            pinocchio.framesForwardKinematics(model, data, q)
            for index, made in wanted:
                made[state] = placements[index].homogeneous
        return out


def timed(what: Callable[[], object]) -> float:
    """Return the CPU seconds of a call."""
    begin = time.process_time()
    what()
    return time.process_time() - begin


def main(pairs: int) -> None:
    """Print the table."""
    made = compile_robot(ROBOT)
    if made.robot is None:
        raise SystemExit("the reference robot does not compile")
    urdf = next(artifact.text for artifact in made.artifacts if artifact.file.endswith(".urdf"))
    random = np.random.default_rng(1)
    positions = {f"joint{i}": random.uniform(-2, 2, STATES) for i in range(1, 6)}
    ours, loop = Kinematics(made.robot), Loop(urdf, positions)
    kept = loop.kept(list(loop.frames))
    found = ours.all_frames(BASE, positions, kept)
    apart = max(float(abs(found[name][0] - kept[name][:, :3, :3]).max()) for name in kept)
    print(f"{len(kept)} frames, {STATES:,} states, rotations apart by {apart:.1e}")
    print(f"{'kinematics / pinocchio':<42} {'ours':>11} {'pinocchio':>11}   ratio, median of {pairs} pairs")

    def chain() -> object:
        return ours.transforms(BASE, CAMERA, positions)

    def every() -> object:
        return ours.all_frames(BASE, positions, kept)

    for case, first, second in (
        ("one chain, bare loop", chain, loop.bare_chain),
        ("one chain, kept", chain, lambda: loop.kept([CAMERA])),
        ("all frames, bare loop", every, loop.bare_all),
        ("all frames, kept", every, lambda: loop.kept(list(loop.frames))),
    ):
        ratio = compare(lambda first=first: timed(first), lambda second=second: timed(second), pairs)  # type: ignore[misc]
        print(row(case, ratio, GOAL))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
