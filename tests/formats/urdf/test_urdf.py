"""The URDF, held against three of its readers: urdfdom, pinocchio and yourdfpy."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.model import Capsule, Joint, Link, Output, Robot, Shape, Transform
from support.machines import BOX, TESTER
from support.robots import compiled, texts
from support.urdf_robots import emit, parsed

STATES = 200


# One may come with pinocchio, another (older) one with the distribution.
CHECKERS = [path for path in {shutil.which("check_urdf"): 1, "/usr/bin/check_urdf": 2} if path and Path(path).exists()]


@pytest.mark.parametrize("checker", CHECKERS)
def test_urdfdom_accepts_it_without_a_word(checker: str, tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    for text in (emit(TESTER), emit(TESTER, {"number_format": "six"}), texts(compiled())["rosorin.urdf"]):
        path.write_text(text, "utf-8")
        checked = subprocess.run([checker, path], capture_output=True, text=True, check=False)
        assert (checked.returncode, checked.stderr) == (0, "")
        assert "Successfully Parsed XML" in checked.stdout
        assert "root Link: base_link" in checked.stdout


def states(robot: Robot) -> list[dict[str, float]]:
    """Return random positions of the joints that lead, those that follow, and all the others."""
    random = np.random.default_rng(12)
    leaders = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    drawn = [{joint.name: float(random.uniform(*_range(joint))) for joint in leaders} for _ in range(STATES)]
    return [{j.name: robot.position(j, state) for j in robot.joints if j.moves} for state in drawn]


def _range(joint: Joint) -> tuple[float, float]:
    limit = joint.limit
    if limit is None or limit.lower is None or limit.upper is None:
        return (-math.pi, math.pi)
    return (limit.lower, limit.upper)


def expected(robot: Robot, root: str, target: str, positions: Mapping[str, float]) -> np.ndarray:
    leaders = {name: value for name, value in positions.items() if robot.joint[name].mimic is None}
    return matrix(robot.transform(root, target, leaders))


def matrix(transform: Transform) -> np.ndarray:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = transform.rows, transform.xyz
    return made


def pinocchio_frames(text: str, states: list[dict[str, float]]) -> list[dict[str, np.ndarray]]:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(text)
    data = model.createData()
    found = []
    for state in states:
        step = np.zeros(model.nv)
        for name, value in state.items():
            if model.existJointName(name):
                step[model.joints[model.getJointId(name)].idx_v] = value
        pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), step))
        bodies = [(f.name, i) for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY]
        found.append({name: data.oMf[i].homogeneous.copy() for name, i in bodies})
    return found


def yourdfpy_frames(path: Path, states: list[dict[str, float]]) -> list[dict[str, np.ndarray]]:
    yourdfpy = pytest.importorskip("yourdfpy")
    robot = yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=True)
    found = []
    for state in states:
        # It computes the followers itself.
        robot.update_cfg({name: value for name, value in state.items() if name in robot.actuated_joint_names})
        found.append({name: np.array(robot.get_transform(name)) for name in robot.link_map})
    return found


def worst_of(robot: Robot, text: str, path: Path) -> float:
    """Return how far two engines are from the model at most, over all frames and many states (metres, or a cosine)."""
    path.write_text(text, "utf-8")
    drawn = states(robot)
    names = [element.get("name", "") for element in parsed(text).findall("link")]
    worst = 0.0
    for found in (pinocchio_frames(text, drawn), yourdfpy_frames(path, drawn)):
        for state, frames in zip(drawn, found, strict=True):
            for name in names:
                worst = max(worst, float(abs(frames[name] - expected(robot, "base_link", name, state)).max()))
    return worst


@pytest.mark.slow
def test_two_engines_place_every_frame_where_the_model_does(tmp_path: Path) -> None:
    assert worst_of(TESTER, emit(TESTER), tmp_path / "robot.urdf") < 1e-12
    assert 1e-8 < worst_of(TESTER, emit(TESTER, {"number_format": "six"}), tmp_path / "robot.urdf") < 5e-6
    made = compiled()
    assert made.robot is not None
    assert worst_of(made.robot, texts(made)["rosorin.urdf"], tmp_path / "robot.urdf") < 2e-6


def test_colours_without_a_name_get_one_each() -> None:
    shapes = tuple(Shape(BOX, rgba=(n / 4, 0, 0, 1)) for n in range(3))
    text = emit(Robot("r", (Link("a", visual=shapes),), ()))
    names = [material.get("name") for material in parsed(text).iter("material")]
    assert len(set(names)) == 3


def test_a_capsule_is_a_cylinder_of_its_full_length_and_that_is_said() -> None:
    robot = Robot("r", (Link("a", collision=(Shape(Capsule(0.1, 0.4)),)),), ())
    text, diagnostics = urdf.write(robot, Output("urdf", "urdf", "r.urdf"), Templates())
    sizes = next(parsed(text).iter("cylinder")).attrib
    assert sizes["radius"] == "0.1"
    assert float(sizes["length"]) == pytest.approx(0.6)
    assert [(d.rule, d.severity) for d in diagnostics] == [("urdf-cannot-say", "warning")]


def test_elements_are_chosen() -> None:
    for wanted in ([], ["collision"], ["inertial"], ["visual", "dynamics"]):
        found = {element.tag for element in parsed(emit(TESTER, {"elements": wanted})).iter()}
        assert found & {"collision", "inertial", "visual", "dynamics"} == set(wanted)


# What the schema of descriptions lets pass as a name, and XML might trip over, in attributes or in comments.
ODD_NAMES = ["a--b", "a-", "---", "]]", "weiß", "{{x}}", "{%x%}", "a|b", "x\\y", "🤖", "?", "!", "%s"]


@pytest.mark.parametrize("name", ODD_NAMES)
def test_any_legal_name(name: str) -> None:
    stand_in = Shape(BOX, stand_in=f"<{name}> & --> {name}")
    painted = Shape(BOX, material=name, rgba=(1, 1, 1, 1))
    links = (Link(name, collision=(stand_in,)), Link(name + "2", visual=(painted,)))
    root = parsed(emit(Robot(name, links, (Joint(name, "fixed", name, name + "2"),))))
    assert root.get("name") == name
    assert [element.get("name") for element in root.findall("link")] == [name, name + "2"]
    assert root.find("joint/child").get("link") == name + "2"  # type: ignore[union-attr]
    assert root.find("link/visual/material").get("name") == name  # type: ignore[union-attr]
