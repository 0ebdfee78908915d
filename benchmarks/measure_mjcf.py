"""Compare one MJCF file with reference numbers of the URDF that it was converted from.

``benchmarks/converters.py`` runs this file with the Python of the environment that has the newest MuJoCo:
``python benchmarks/measure_mjcf.py REFERENCE.json ROBOT.xml``. It needs mujoco and numpy, and prints one JSON object.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

TOLERANCE = 1e-5  # of numbers, relative: MuJoCo writes six digits
EQUAL_JOINT = mujoco.mjtEq.mjEQ_JOINT


def measure(reference: dict[str, Any], path: str) -> dict[str, Any]:
    """Load an MJCF and return its differences from the reference.

    ``urdf_reference.reference`` documents the reference. The result is ``error`` alone if MuJoCo refuses the file.
    """
    try:
        model = mujoco.MjModel.from_xml_path(path)
    except ValueError as problem:
        return {"error": str(problem).strip().replace("\n", ", ")}
    data = mujoco.MjData(model)
    joints = {name: joint for name in reference["joints"] if (joint := _id(model, "JOINT", name)) >= 0}
    frames = {name: frame for name in reference["links"] if (frame := _frame(model, name)) is not None}
    expected = {name: reference["joints"][name] for name in joints}
    return {
        "frames": len(frames),
        **_errors_of_states(model, data, reference, joints, frames),
        "mass": float(model.body_mass.sum()) - reference["mass"],
        "visuals": sum(_is_drawn(model, _body(model, frames.get(link))) for link in reference["visuals"]),
        "mimic": sum(
            _follows(model, joints, name, entry["mimic"]) for name, entry in expected.items() if entry["mimic"]
        ),
        "damping": sum(
            _close(_of_dof(model, "damping", joints[name]), entry["damping"]) for name, entry in expected.items()
        ),
        "friction": sum(
            _close(_of_dof(model, "frictionloss", joints[name]), entry["friction"]) for name, entry in expected.items()
        ),
        "limits": sum(_limits_equal(model, joints[name], entry) for name, entry in expected.items()),
        "effort": sum(_effort_equal(model, joints[name], entry["effort"]) for name, entry in expected.items()),
        "armature": sum(_of_dof(model, "armature", joint) != 0 for joint in joints.values()),
        "actuators": int(model.nu),
        "pairs": sum(
            _can_touch(model, *({_body(model, frames.get(link)) for link in links} for links in pair))
            for pair in reference["pairs"]
        ),
        "contacts": _touching_pairs(model, data, reference, joints),
    }


def _id(model: Any, kind: str, name: str) -> int:
    return mujoco.mj_name2id(model, getattr(mujoco.mjtObj, f"mjOBJ_{kind}"), name)


def _frame(model: Any, name: str) -> tuple[str, int] | None:
    """Return the body of that name, or else the site, or None."""
    for kind, prefix in (("BODY", "x"), ("SITE", "site_x")):
        if (index := _id(model, kind, name)) >= 0:
            return prefix, index
    return None


def _pose(data: Any, frame: tuple[str, int]) -> np.ndarray:
    prefix, index = frame
    pose = np.eye(4)
    pose[:3, :3] = getattr(data, f"{prefix}mat")[index].reshape(3, 3)
    pose[:3, 3] = getattr(data, f"{prefix}pos")[index]
    return pose


def _errors_of_states(model: Any, data: Any, reference: dict[str, Any], joints: dict, frames: dict) -> dict[str, float]:
    """Return the largest errors over all states: positions (m), angles (rad), and joint-space inertia (relative)."""
    position = angle = inertia = 0.0
    names = list(reference["joints"])
    rows = [names.index(name) for name in joints]
    dofs = [model.jnt_dofadr[joint] for joint in joints.values()]
    root = frames.get(reference["links"][0], ("x", 0))  # a fixed root can be the world itself
    for state in reference["states"]:
        _move(model, data, joints, state["q"])
        mujoco.mj_forward(model, data)
        from_root = np.linalg.inv(_pose(data, root))
        for name, frame in frames.items():
            expected, actual = np.array(state["poses"][name]), from_root @ _pose(data, frame)
            position = max(position, float(np.linalg.norm(actual[:3, 3] - expected[:3, 3])))
            difference = np.linalg.norm(actual[:3, :3] - expected[:3, :3]) / np.sqrt(8)  # sin(angle / 2)
            angle = max(angle, float(2 * np.arcsin(min(1, difference))))
        if dofs:
            full = np.zeros((model.nv, model.nv))
            mujoco.mj_fullM(model, data, full)
            full = (full - np.diag(model.dof_armature))[np.ix_(dofs, dofs)]
            wanted = np.array(state["inertia"])[np.ix_(rows, rows)]
            inertia = max(inertia, float(np.abs(full - wanted).max() / np.abs(wanted).max()))
    return {"position": position, "angle": angle, "inertia": inertia}


def _move(model: Any, data: Any, joints: dict[str, int], positions: dict[str, float]) -> None:
    mujoco.mj_resetData(model, data)
    for name, joint in joints.items():
        data.qpos[model.jnt_qposadr[joint]] = positions[name]


def _of_dof(model: Any, field: str, joint: int) -> float:
    return float(np.ravel(getattr(model, f"dof_{field}")[model.jnt_dofadr[joint]])[0])


def _close(actual: float, expected: float) -> bool:
    return abs(actual - expected) <= TOLERANCE * max(1, abs(expected))


def _follows(model: Any, joints: dict[str, int], name: str, mimic: dict[str, Any]) -> bool:
    """Return True if an equality constraint makes a joint follow the joint that it mimics."""
    leader = joints.get(mimic["joint"])
    for index in range(model.neq):
        if model.eq_type[index] != EQUAL_JOINT or not model.eq_active0[index]:
            continue
        pair, (offset, factor) = (model.eq_obj1id[index], model.eq_obj2id[index]), model.eq_data[index][:2]
        if pair == (joints[name], leader):
            return _close(offset, mimic["offset"]) and _close(factor, mimic["multiplier"])
        if pair == (leader, joints[name]):
            return _close(factor * mimic["multiplier"], 1) and _close(offset * mimic["multiplier"], -mimic["offset"])
    return False


def _limits_equal(model: Any, joint: int, entry: dict[str, Any]) -> bool:
    if entry["limits"] is None or not model.jnt_limited[joint]:
        return entry["limits"] is None and not model.jnt_limited[joint]
    return all(_close(*pair) for pair in zip(model.jnt_range[joint], entry["limits"], strict=True))


def _effort_equal(model: Any, joint: int, effort: float) -> bool:
    """Return True if the force of a joint, or else of an actuator on it, is limited to the effort of the URDF."""
    ranges = [model.jnt_actfrcrange[joint]] if model.jnt_actfrclimited[joint] else []
    for index in range(model.nu):
        if model.actuator_trnid[index][0] == joint and model.actuator_forcelimited[index]:
            ranges.append(model.actuator_forcerange[index])
    return any(_close(low, -effort) and _close(high, effort) for low, high in ranges) if effort else not ranges


def _can_touch(model: Any, first: set[int], second: set[int]) -> bool:
    """Return True if MuJoCo tests any geom of the first bodies against one of the second, by masks and excludes."""
    excluded = {int(signature) for signature in model.exclude_signature}
    for a in (index for index in range(model.ngeom) if model.geom_bodyid[index] in first):
        for b in (index for index in range(model.ngeom) if model.geom_bodyid[index] in second):
            low, high = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
            masks = (
                model.geom_contype[a] & model.geom_conaffinity[b] | model.geom_contype[b] & model.geom_conaffinity[a]
            )
            if masks and (low << 16) + high not in excluded:
                return True
    return False


def _is_drawn(model: Any, body: int) -> bool:
    """Return True if a body has a geom for the looks alone, without contacts."""
    masks = (model.geom_contype | model.geom_conaffinity)[model.geom_bodyid == body]
    return bool((masks == 0).any())


def _body(model: Any, frame: tuple[str, int] | None) -> int:
    if frame is None:
        return -1
    return frame[1] if frame[0] == "x" else int(model.site_bodyid[frame[1]])


def _touching_pairs(model: Any, data: Any, reference: dict[str, Any], joints: dict[str, int]) -> int:
    """Count the pairs of bodies of the robot in contact in the rest pose: the zero pose, moved into the limits."""
    _move(model, data, joints, reference["rest"])
    mujoco.mj_forward(model, data)
    bodies = [sorted(int(model.geom_bodyid[geom]) for geom in data.contact[index].geom) for index in range(data.ncon)]
    return len({(first, second) for first, second in bodies if first})


if __name__ == "__main__":
    print(json.dumps(measure(json.loads(Path(sys.argv[1]).read_text("utf-8")), sys.argv[2]), default=int))
