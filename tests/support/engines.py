"""What each consumer of an artifact says about where a frame is: one small reader an engine.

Every reader has ``frames(positions)``: joint positions in radians by name -> frame -> 4x4 pose in base_link.
"""

from __future__ import annotations

import ast
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Pose = NDArray[np.float64]
Frames = dict[str, Pose]
BASE = "base_link"


def rpy_matrix(roll: float, pitch: float, yaw: float) -> Pose:
    """Return the 3x3 rotation of fixed-axis roll, pitch, yaw."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return np.asarray(z @ y @ x)


def pose(xyz: object, rpy: object) -> Pose:
    """Return a 4x4 pose of xyz and rpy."""
    made = np.eye(4)
    made[:3, 3] = np.asarray(xyz, float)
    made[:3, :3] = rpy_matrix(*np.asarray(rpy, float))
    return made


class Pinocchio:
    """The URDF as pinocchio (and its urdfdom) reads it."""

    def __init__(self, urdf: str) -> None:
        import pinocchio

        self.pin = pinocchio
        self.model = pinocchio.buildModelFromXML(urdf)
        self.data = self.model.createData()

    def frames(self, positions: Mapping[str, float]) -> Frames:
        q = self.pin.neutral(self.model)
        for name, value in positions.items():
            if self.model.existJointName(name):
                q[self.model.joints[self.model.getJointId(name)].idx_q] = value
        self.pin.framesForwardKinematics(self.model, self.data, q)
        bodies = [(f.name, i) for i, f in enumerate(self.model.frames) if f.type == self.pin.FrameType.BODY]
        found = {name: self.data.oMf[i].homogeneous for name, i in bodies}
        base = np.linalg.inv(found[BASE])
        return {name: base @ placed for name, placed in found.items()}


class Yourdfpy:
    """The URDF as yourdfpy reads it."""

    def __init__(self, path: Path) -> None:
        import yourdfpy

        self.robot = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=True)

    def frames(self, positions: Mapping[str, float]) -> Frames:
        known = {name: value for name, value in positions.items() if name in self.robot.joint_map}
        self.robot.update_cfg(known)
        return {name: np.array(self.robot.get_transform(name, BASE)) for name in self.robot.link_map}


class MuJoCo:
    """The MJCF as MuJoCo compiles it; ``kind`` is "site" or "body"."""

    def __init__(self, mjcf: str, kind: str = "site") -> None:
        import mujoco

        self.mujoco = mujoco
        self.model = mujoco.MjModel.from_xml_string(mjcf)
        self.data = mujoco.MjData(self.model)
        self.kind = kind

    def frames(self, positions: Mapping[str, float]) -> Frames:
        self.data.qpos[:] = self.model.qpos0
        for name, value in positions.items():
            self.data.qpos[self.model.joint(name).qposadr[0]] = value
        self.mujoco.mj_kinematics(self.model, self.data)
        kind = self.mujoco.mjtObj.mjOBJ_SITE if self.kind == "site" else self.mujoco.mjtObj.mjOBJ_BODY
        count = self.model.nsite if self.kind == "site" else self.model.nbody
        found: Frames = {}
        for index in range(count):
            name = self.mujoco.mj_id2name(self.model, kind, index)
            placed = np.eye(4)
            xpos, xmat = (
                (self.data.site_xpos, self.data.site_xmat) if self.kind == "site" else (self.data.xpos, self.data.xmat)
            )
            placed[:3, 3], placed[:3, :3] = xpos[index], xmat[index].reshape(3, 3)
            found[name] = placed
        base = np.linalg.inv(found[BASE])
        return {name: base @ placed for name, placed in found.items()}


class RobotModel:
    """The driver's model JSON, chained by hand."""

    def __init__(self, text: str, names: Mapping[str, str]) -> None:
        self.joints = json.loads(text)["joints"]
        self.names = names

    def frames(self, positions: Mapping[str, float]) -> Frames:
        edges = {j["child"]: (name, j) for name, j in self.joints.items()}
        found: Frames = {}
        for child in edges:
            placed, link = np.eye(4), child
            while link in edges:
                name, joint = edges[link]
                placed = pose(joint["xyz"], joint["rpy"]) @ _turn(joint, positions.get(name, 0.0)) @ placed
                link = joint["parent"]
            found[child] = placed
        base = np.linalg.inv(found[BASE])
        found[link] = np.eye(4)
        return {self.names.get(name, name): base @ placed for name, placed in found.items()}


def _turn(joint: Mapping[str, object], angle: float) -> Pose:
    made = np.eye(4)
    if joint["type"] == "fixed":
        return made
    axis = np.asarray(joint["axis"], float)
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    made[:3, :3] = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return made


class StaticTf:
    """Arguments of static_transform_publisher, read by the rules of geometry2's command line."""

    def __init__(self, arguments: list[list[str]]) -> None:
        self.edges = [self._parse(words) for words in arguments]

    @classmethod
    def from_json(cls, text: str) -> StaticTf:
        return cls([entry["arguments"] for entry in json.loads(text)["static_transform_publisher"]])

    @classmethod
    def from_launch(cls, text: str) -> StaticTf:
        found = []
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.List) and any(
                isinstance(i, ast.Constant) and i.value == "--frame-id" for i in node.elts
            ):
                # A frame is [frame_prefix, NAME]: the prefix is empty unless a launch gives one.
                found.append([(item.elts[1] if isinstance(item, ast.List) else item).value for item in node.elts])
        return cls(found)

    @staticmethod
    def _parse(words: list[str]) -> tuple[str, str, Pose]:
        given = dict(zip(words[::2], words[1::2], strict=True))
        number = {name: float(given.pop(f"--{name}", "0")) for name in ("x", "y", "z", "roll", "pitch", "yaw")}
        parent, child = given.pop("--frame-id"), given.pop("--child-frame-id")
        assert not given, f"arguments that static_transform_publisher does not know: {given}"
        xyz = [number[name] for name in ("x", "y", "z")]
        return parent, child, pose(xyz, [number[name] for name in ("roll", "pitch", "yaw")])

    def frames(self, _positions: Mapping[str, float]) -> Frames:
        return {child: placed for parent, child, placed in self.edges if parent == BASE}
