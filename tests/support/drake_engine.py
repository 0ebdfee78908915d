"""Engine: what Drake makes of SDF files. A program of its own for a Python that has Drake; it imports none of ours.

Standard input is JSON: ``files``, the frame ``root``, and ``states`` (positions by joint). It prints, for each file,
``refused`` or: ``frames``, 4x4 poses in the frame ``root`` by name for each of the states; ``masses`` and ``inertias``
(3x3 about the centre of mass along the link, and the centre) by link; ``joints``: type and limits by name. A link or
frame of a model within is called MODEL_NAME; a joint has the name that it has there.
"""

import json
import sys
from typing import Any


def main() -> None:
    """Answer one question."""
    asked = json.load(sys.stdin)
    json.dump([_file(path, asked["root"], asked["states"]) for path in asked["files"]], sys.stdout)


def _file(path: str, root: str, states: list[dict[str, Any]]) -> dict[str, Any]:
    from pydrake.multibody.parsing import Parser  # type: ignore[import-not-found]
    from pydrake.multibody.plant import MultibodyPlant  # type: ignore[import-not-found]
    from pydrake.multibody.tree import BodyIndex, FrameIndex  # type: ignore[import-not-found]

    plant = MultibodyPlant(0.001)
    try:
        Parser(plant).AddModels(path)
        plant.Finalize()
    except RuntimeError as problem:
        return {"refused": str(problem)}
    frames = [plant.get_frame(FrameIndex(index)) for index in range(plant.num_frames())]
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    by_name = {joint.name(): joint for joint in joints}
    context = plant.CreateDefaultContext()
    seen = next(frame for frame in frames if _called(frame) == root)
    found = []
    for state in states:
        for name, position in state.items():
            if name in by_name:
                _put(plant, context, by_name[name], position if isinstance(position, list) else [position])
        found.append({_called(frame): frame.CalcPose(context, seen).GetAsMatrix4().tolist() for frame in frames})
    masses, inertias = {}, {}
    for body in bodies:
        spatial = body.CalcSpatialInertiaInBodyFrame(context)
        centre = spatial.get_com()
        about = spatial.Shift(centre).CalcRotationalInertia().CopyToFullMatrix3()
        masses[_called(body)], inertias[_called(body)] = spatial.get_mass(), [about.tolist(), list(centre)]
    said = {
        joint.name(): [joint.type_name(), list(joint.position_lower_limits()), list(joint.position_upper_limits())]
        for joint in joints
    }
    return {"frames": found, "masses": masses, "inertias": inertias, "joints": said}


def _put(plant: Any, context: Any, joint: Any, position: list[float]) -> None:
    if joint.num_positions() == len(position):
        values, start = plant.GetPositions(context), joint.position_start()
        values[start : start + len(position)] = position
        plant.SetPositions(context, values)


def _called(one: Any) -> str:
    return "_".join(str(one.scoped_name()).split("::")[1:])


if __name__ == "__main__":
    main()
