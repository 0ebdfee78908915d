"""The judges of an imported MJCF: MuJoCo has the file, pinocchio the URDF that our description of it compiles to."""

from __future__ import annotations

import tempfile
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio
from numpy.typing import NDArray

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.formats.imported_robot import ImportedRobot, ReadOptions
from rosorin_compile.formats.robot_files import outputs_of
from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.importing.description import write
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from rosorin_compile.mujoco.mjcf.unsupported import position_range
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import ROOT_FILE


class Case(NamedTuple):
    """A file that was imported: what came of it, the robot, MuJoCo's own model of it, and the MJCF that it becomes."""

    imported: ImportedRobot
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


def frames_differ(case: Case, count: int) -> float:
    """Return the largest difference of any entry of any body's frame, over random states, relative to the root.

    Balls and what floats stay where they begin.
    """
    judge = pinocchio.buildModelFromXML(urdf_of(case.robot))
    judge_data, data, robot = judge.createData(), mujoco.MjData(case.model), case.robot
    links, joints = case.imported.names["body"], case.imported.names["joint"]
    root = next((index for index, name in links.items() if name == robot.root), 0)
    chance, worst = np.random.default_rng(20261120), 0.0
    for _ in range(count):
        free = [joint for joint in robot.joints if joint.moves and not joint.mimic]
        state = {joint.name: float(chance.uniform(*(position_range(joint) or (-1.0, 1.0)))) for joint in free}
        data.qpos[:], q = case.model.qpos0, pinocchio.neutral(judge)
        for index, joint in ((index, robot.joint[name]) for index, name in joints.items()):
            if joint.moves:
                at, of_judge = robot.position(joint, state), judge.joints[judge.getJointId(joint.name)]
                data.qpos[case.model.jnt_qposadr[index]] = at
                values = (np.cos(at), np.sin(at)) if of_judge.nq == 2 else at
                q[of_judge.idx_q : of_judge.idx_q + of_judge.nq] = values
        mujoco.mj_kinematics(case.model, data)
        pinocchio.framesForwardKinematics(judge, judge_data, q)
        back = np.linalg.inv(_frame(data, root))
        for index, name in links.items():
            theirs = judge_data.oMf[judge.getFrameId(name, pinocchio.BODY)].homogeneous
            worst = max(worst, float(np.abs(back @ _frame(data, index) - theirs).max()))
    return worst


def _frame(data: Any, body: int) -> NDArray[np.float64]:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = data.xmat[body].reshape(3, 3), data.xpos[body]
    return made
