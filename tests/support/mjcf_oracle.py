"""The judges of an imported MJCF: MuJoCo has the file, pinocchio the URDF that our description of it compiles to."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import Imported, ReadOptions
from rosorin_compile.formats.robot_files import outputs_of
from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.importing.description import write
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import ROOT_FILE

FREE, BALL = 0, 1
Matrix = NDArray[np.float64]


class Case(NamedTuple):
    """A file that was imported: what came of it, the robot, MuJoCo's own model of it, and the MJCF that it becomes."""

    imported: Imported
    robot: Robot
    model: Any
    text: str


def imported(path: Path, options: ReadOptions = ReadOptions()) -> Case:  # noqa: B008 - it is frozen
    """Import a file, write the description that it becomes, and compile that, without an error."""
    made = read_mjcf(path, options)
    assert made.tree is not None, [d.message for d in made.diagnostics]
    assert validate(made.tree, FORMATS) == []
    with tempfile.TemporaryDirectory() as folder:
        for name, text in write(made, outputs_of(made)).items():
            Path(folder, name).write_text(text, "utf-8")
        compiled = compile_robot(Path(folder, ROOT_FILE))
    assert not has_errors(compiled.diagnostics), [d.message for d in compiled.diagnostics if d.severity == "error"]
    assert compiled.robot is not None
    spec = mujoco.MjSpec.from_file(str(path))
    spec.compiler.fusestatic = spec.compiler.discardvisual = False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the importer passes them on
        model = spec.compile()
    text = next(one.text for one in compiled.artifacts if one.backend == "mjcf")
    return Case(made, compiled.robot, model, text)


def urdf_of(robot: Robot) -> str:
    """Return the kinematics of a robot as URDF: pinocchio is to look at frames, not for meshes."""
    bare = replace(robot, links=tuple(replace(link, visual=(), collision=()) for link in robot.links))
    options = {"elements": ["inertial"]}
    return urdf.write(bare, Output("urdf", "urdf", "robot.urdf", options), Templates())[0]


def states(case: Case, count: int) -> Iterator[Matrix]:
    """Yield random positions of MuJoCo's joints, followers where their leader puts them."""
    generator = np.random.default_rng(20261120)
    model = case.model
    for _ in range(count):
        qpos = model.qpos0.copy()
        for index in range(model.njnt):
            at, kind = model.jnt_qposadr[index], model.jnt_type[index]
            if kind == FREE:
                qpos[at : at + 3] = generator.uniform(-1, 1, 3)
                at += 3
            if kind in (FREE, BALL):
                x, y, z, w = Rotation.random(random_state=generator).as_quat()
                qpos[at : at + 4] = w, x, y, z
                continue
            low, high = model.jnt_range[index] if model.jnt_limited[index] else (-1.0, 1.0)
            qpos[at] = generator.uniform(low, high)
        _follow(case, qpos)
        yield qpos


def _follow(case: Case, qpos: Matrix) -> None:
    """Put followers where their leaders want them; twice for each, for followers of followers."""
    model = case.model
    for _ in range(model.neq):
        for index in range(model.neq):
            first, second = (int(ids[index]) for ids in (model.eq_obj1id, model.eq_obj2id))
            if model.eq_type[index] != mujoco.mjtEq.mjEQ_JOINT or second < 0 or not model.eq_active0[index]:
                continue
            a, b = model.jnt_qposadr[first], model.jnt_qposadr[second]
            x = qpos[b] - model.qpos0[b]
            qpos[a] = model.qpos0[a] + sum(model.eq_data[index][k] * x**k for k in range(5))


def link_names(case: Case) -> dict[int, str]:
    """Return our link of each body of MuJoCo: they stand in MuJoCo's order, and keep the names that they have."""
    ours = list(case.imported.tree["links"]) if case.imported.tree is not None else []
    first = 0 if ours[0] == "ground" != case.model.body(1).name else 1
    made = {index: ours[index - first] for index in range(first, case.model.nbody)}
    assert made
    assert all(case.model.body(index).name in ("", "world", name) for index, name in made.items())
    return made


def joint_names(case: Case) -> dict[int, list[str]]:
    """Return our moving joint of each joint of MuJoCo, none for the base; names are kept."""
    ours = iter([joint for joint in case.robot.joints if joint.type != "fixed"])
    floats = any(joint.type == "floating" for joint in case.robot.joints)
    made: dict[int, list[str]] = {}
    for index in range(case.model.njnt):
        kind, name = case.model.jnt_type[index], case.model.joint(index).name
        count = 0 if kind == FREE and not floats else 1
        made[index] = [next(ours).name for _ in range(count)]
        assert not name or made[index] == [name] * count
    assert next(ours, None) is None
    return made


def positions(case: Case, qpos: Matrix) -> dict[str, Any]:
    """Return the positions of our joints at a state of MuJoCo: a number, or a pose for a floating joint."""
    model, found = case.model, {}
    for index, names in joint_names(case).items():
        at, kind = model.jnt_qposadr[index], model.jnt_type[index]
        if kind == BALL:
            values: Any = [qpos[at : at + 4]]
        else:
            values = [qpos[at : at + 7] if kind == FREE else float(qpos[at])]
        found |= dict(zip(names, values, strict=False))
    return found


def _rotation(quaternion: Matrix) -> Rotation:
    w, x, y, z = quaternion
    return Rotation.from_quat([x, y, z, w])


class Pinocchio:
    """Where pinocchio has the links of a robot."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.model = pinocchio.buildModelFromXML(urdf_of(robot))
        self.data = self.model.createData()

    def frames(self, at: dict[str, Any]) -> dict[str, Matrix]:
        """Return the links as 4x4 matrices in the root, by name."""
        q = pinocchio.neutral(self.model)
        for name, value in at.items():
            if not self.model.existJointName(name):
                continue
            joint = self.model.joints[self.model.getJointId(name)]
            if joint.nq == 7:
                q[joint.idx_q : joint.idx_q + 7] = self._floating(name, value)
            elif joint.nq == 2:
                q[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
            else:
                q[joint.idx_q] = value
        pinocchio.framesForwardKinematics(self.model, self.data, q)
        return {
            frame.name: self.data.oMf[index].homogeneous
            for index, frame in enumerate(self.model.frames)
            if frame.type == pinocchio.BODY
        }

    def _floating(self, name: str, value: Matrix) -> list[float]:
        """Return the position of a floating joint, which counts from the joint's origin, as a ball does anyway."""
        if len(value) == 4:
            return [0.0, 0.0, 0.0, *_rotation(value).as_quat()]
        joint = self.robot.joint[name]
        rows, xyz = np.array(joint.origin.transform().rows), np.array(joint.origin.xyz)
        turn = Rotation.from_matrix(rows.T) * _rotation(value[3:])
        return [*(rows.T @ (value[:3] - xyz)), *turn.as_quat()]


def frames_differ(case: Case, count: int) -> float:
    """Return the largest difference of any entry of any body's frame, over random states, relative to the root."""
    engine, data = Pinocchio(case.robot), mujoco.MjData(case.model)
    names = link_names(case)
    worst = 0.0
    for qpos in states(case, count):
        data.qpos[:] = qpos
        mujoco.mj_kinematics(case.model, data)
        ours = engine.frames(positions(case, qpos))
        back = np.linalg.inv(_frame(data, min(names)))
        for index, name in names.items():
            worst = max(worst, float(np.abs(back @ _frame(data, index) - ours[name]).max()))
    return worst


def _frame(data: Any, body: int) -> Matrix:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
    return made
