"""What Drake makes of an SDF: asked in a process of its own, with the Python that has it (DRAKE, as .ci/run sets it).

This file is that process's program, too: it imports nothing of ours.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

PYTHON = os.environ.get("DRAKE", "")


def need() -> None:
    """Skip the test where Drake is not installed."""
    import pytest

    if not PYTHON:
        pytest.skip("DRAKE names no Python that has Drake: pip install drake==1.51.1 in an environment of its own")


class Refused(Exception):
    """What Drake says that it does not load."""


def ask(path: Path, root: str, states: list[dict[str, Any]] | None = None, *, quiet: bool = True) -> dict[str, Any]:
    """Return what Drake reads out of an SDF.

    ``frames``: 4x4 poses in the frame ``root``, by name, for each of the states (positions by joint); ``masses`` and
    ``inertias`` (3x3 about the centre of mass along the link, and the centre) by link; ``joints``: type, axis and
    limits by name. A link or frame of a model within is called MODEL_NAME. With ``quiet`` Drake may warn of nothing
    but sensors and what it cannot do in this plant.
    Raises Refused.
    """
    words = json.dumps({"path": str(path), "root": root, "states": states or [{}]})
    ran = subprocess.run(
        [PYTHON, "-P", __file__], input=words, capture_output=True, text=True, timeout=120, check=False
    )
    if ran.returncode == 3:
        raise Refused(ran.stdout.strip())
    assert ran.returncode == 0, ran.stderr
    if quiet:
        known = ("in link: sensor", "in joint: sensor", "imic element", "Coulomb friction", "gravity")
        told = [line for line in ran.stderr.splitlines() if "warning" in line.lower()]
        assert [line for line in told if not any(word in line for word in known)] == []
    found: dict[str, Any] = json.loads(ran.stdout)
    return found


def called(one: Any) -> str:
    """Return the name of something with those of the models within the first one before it."""
    return "_".join(str(one.scoped_name()).split("::")[1:])


def main() -> None:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import BodyIndex, FrameIndex

    asked = json.load(sys.stdin)
    plant = MultibodyPlant(0.001)
    try:
        Parser(plant).AddModels(asked["path"])
        plant.Finalize()
    except RuntimeError as problem:
        print(problem)
        sys.exit(3)
    context = plant.CreateDefaultContext()
    frames = [plant.get_frame(FrameIndex(index)) for index in range(plant.num_frames())]
    root = next(frame for frame in frames if called(frame) == asked["root"])
    found = []
    joints = {plant.get_joint(index).name(): plant.get_joint(index) for index in plant.GetJointIndices()}
    for state in asked["states"]:
        for name, position in state.items():
            values = position if isinstance(position, list) else [position]
            all_of = plant.GetPositions(context)
            start = joints[name].position_start()
            all_of[start : start + len(values)] = values
            plant.SetPositions(context, all_of)
        found.append({called(f): f.CalcPose(context, root).GetAsMatrix4().tolist() for f in frames})
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    masses, inertias = {}, {}
    for body in bodies:
        spatial = body.CalcSpatialInertiaInBodyFrame(context)
        centre = spatial.get_com()
        about = spatial.Shift(centre).CalcRotationalInertia().CopyToFullMatrix3()
        masses[called(body)], inertias[called(body)] = spatial.get_mass(), [about.tolist(), list(centre)]
    said = {
        name: [joint.type_name(), list(joint.position_lower_limits()), list(joint.position_upper_limits())]
        for name, joint in joints.items()
    }
    json.dump({"frames": found, "masses": masses, "inertias": inertias, "joints": said}, sys.stdout)


if __name__ == "__main__":
    main()
