"""The parts of the library: how they move in MuJoCo, what they say of mistakes, and their page."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

import library_reference  # noqa: E402
from rosorin_compile.formats.compilation import compile_robot  # noqa: E402
from support.robots import compiled  # noqa: E402
from support.simulator import GRAVITY, emitted, load, no_warning, probe, written  # noqa: E402

pytestmark = pytest.mark.slow

NEEDED = {
    "solids/box": "size: [0.1, 0.2, 0.3]",
    "solids/cylinder": "radius: 50 mm, length: 0.2",
    "solids/sphere": "radius: 50 mm",
    "solids/capsule": "radius: 50 mm, length: 0.2",
    "solids/boxes": "boxes: [{size: [1, 1, 1], xyz: [0, 0, 0]}, {size: [1, 2, 1], xyz: [1, 0, 0], rpy: [0, 0, 1]}]",
    "wheels/fixed": "radius: 50 mm, width: 30 mm, mass: 0.2",
    "wheels/steered": "radius: 50 mm, width: 30 mm, mass: 0.2",
    "wheels/caster": "radius: 30 mm, width: 20 mm, mass: 0.1, trail: 25 mm, height: 40 mm",
    "wheels/ball": "radius: 30 mm, mass: 0.1",
    "wheels/mecanum": "radius: 48 mm, width: 40 mm, mass: 0.2",
    "wheels/omni": "radius: 48 mm, width: 30 mm, mass: 0.2",
    "servos/servo": "child: horn, effort: 1.5 N*m, velocity: 5 rad/s",
}


EXAMPLES = re.findall(r"<!-- file: (\S+) -->\n```yaml\n(.*?)```", library_reference.text(), re.DOTALL)


@pytest.mark.parametrize(("name", "text"), EXAMPLES, ids=[name.split("/")[1] for name, _ in EXAMPLES])
def test_the_examples_of_the_page_compile_and_load(tmp_path: Path, name: str, text: str) -> None:
    path = tmp_path / name
    path.parent.mkdir(parents=True)
    path.write_text(text, "utf-8")
    made = compile_robot(path)
    assert [d for d in made.diagnostics if d.severity != "note"] == []
    for artifact in made.artifacts:
        assert artifact.backend != "mjcf" or load(artifact.text)[0].nbody > 1


@pytest.mark.parametrize("name", sorted(NEEDED))
@pytest.mark.parametrize("mirror", ["", ", mirror: y"])
def test_every_part_compiles_and_loads(tmp_path: Path, name: str, mirror: str) -> None:
    horn = "horn: {inertial: {mass: 0.1, of: [sphere: {radius: 20 mm}]}}" if name == "servos/servo" else ""
    use = f"{{part: {name}, parent: base_link, with: {{{NEEDED[name]}}}{mirror}}}"
    text = f"links: {{base_link: {{}}, {horn}}}\nuse: {{it: {use}}}"
    made = compile_robot(written(tmp_path, text))
    assert [d for d in made.diagnostics if d.severity != "note"] == []
    model, _ = load(made.artifacts[0].text)
    assert model.body("horn" if horn else "it_link").id
    assert model.joint("it_joint").id + 1 if "solids" not in name and "ball" not in name else True


CART = """let:
  tyre: {{radius: 48 mm, width: 40 mm, mass: 0.2 kg}}
links:
  base_link: {{inertial: {{mass: 3 kg, of: [box: {{size: [0.3, 0.2, 0.08]}}]}}}}
use:
  fl: {{part: wheels/{kind}, parent: base_link, xyz: [0.1, 0.12, 0], with: "${{tyre}}"}}
  fr: {{part: wheels/{kind}, parent: base_link, xyz: [0.1, -0.12, 0], with: "${{tyre}}", mirror: y}}
  rl: {{part: wheels/{kind}, parent: base_link, xyz: [-0.1, 0.12, 0], with: "${{tyre}}", mirror: y}}
  rr: {{part: wheels/{kind}, parent: base_link, xyz: [-0.1, -0.12, 0], with: "${{tyre}}"}}
"""
WHEELS = ("fl", "fr", "rl", "rr")


def driven(text: str, speeds: tuple[float, ...], wheels: tuple[str, ...], height: float) -> tuple[np.ndarray, float]:
    """Return the speed over ground (m/s, in the axes of the base) and the yaw rate after a second of driving."""
    motors = "".join(f'<velocity joint="{wheel}_joint" kv="0.5"/>' for wheel in wheels)
    assert text.count('<body name="base_link">') == 1
    text = text.replace('<body name="base_link">', f'<body name="base_link" pos="0 0 {height}"><freejoint/>')
    text = text.replace("<worldbody>", '<worldbody><geom type="plane" size="9 9 1"/>')
    model, data = load(text.replace("</mujoco>", f"<actuator>{motors}</actuator></mujoco>"))
    data.ctrl[:] = speeds
    with no_warning():
        mujoco.mj_step(model, data, 300)
        start = data.qpos[:2].copy()
        mujoco.mj_step(model, data, 300)
    assert np.ptp([data.qpos[2], height]) < 3e-3
    return (data.qpos[:2] - start) / 0.6, float(data.qvel[5])


@pytest.mark.parametrize(
    ("directions", "expected", "yaw"),
    [
        ((1, 1, 1, 1), (1, 0), 0),
        ((-1, 1, 1, -1), (0, 1), 0),
        ((1, -1, -1, 1), (0, -1), 0),
        ((0, 1, 1, 0), (0.5, 0.5), 0),
        ((-1, 1, -1, 1), (0, 0), 1 / 0.22),
    ],
)
def test_mecanum_wheels_drive_in_every_direction(tmp_path: Path, directions, expected, yaw) -> None:
    """The kinematics of four mecanum wheels (rollers at 45 degrees), within what rolling on spheres slips: 8 %."""
    speed, radius = 5.0, 0.048
    text = emitted(tmp_path, CART.format(kind="mecanum"))
    found, turning = driven(text, tuple(speed * way for way in directions), WHEELS, 0.0485)
    np.testing.assert_allclose(found / (speed * radius), expected, atol=0.08)
    assert turning / (speed * radius) == pytest.approx(yaw, abs=0.08 * max(1, yaw))


@pytest.mark.parametrize("kind", ["mecanum", "omni"])
@pytest.mark.parametrize("rollers", [0, 6, 9, 12])
def test_rollers_of_a_wheel_touch_neither_each_other_nor_the_hub(tmp_path: Path, kind: str, rollers: int) -> None:
    given = f"{{{NEEDED[f'wheels/{kind}']}, rollers: {rollers}}}"
    model, data = probe(tmp_path, f"use: {{it: {{part: wheels/{kind}, parent: base_link, with: {given}}}}}")
    assert (data.ncon, model.njnt) == (0, 1 + rollers)
    assert model.body_mass.sum() == pytest.approx(0.2)


def test_an_omni_wheel_rolls_and_slides_along_its_axle(tmp_path: Path) -> None:
    text = emitted(tmp_path, CART.format(kind="omni"))
    found, _ = driven(text, (5, 5, 5, 5), WHEELS, 0.0485)
    np.testing.assert_allclose(found / (5 * 0.048), [1, 0], atol=0.05)
    pushed = text.replace("<worldbody>", '<option gravity="0 2 -9.6"/><worldbody>')  # as on a slope to the left
    found, _ = driven(pushed, (0, 0, 0, 0), WHEELS, 0.0485)
    assert found[1] > 0.8 * 2 * 0.6  # m/s, as without friction after 0.3 to 0.9 s
    assert abs(found[0]) < 0.02


def test_a_steered_wheel_is_held_where_it_is_told(tmp_path: Path) -> None:
    wheel = f"{{part: wheels/steered, parent: base_link, with: {{{NEEDED['wheels/steered']}, most: 30 deg}}}}"
    model, data = probe(tmp_path, f"use: {{it: {wheel}}}")
    servo = model.actuator("it_steering_joint")
    np.testing.assert_allclose(servo.ctrlrange, np.radians([-30, 30]))
    data.ctrl[:] = 0.4
    with no_warning():
        mujoco.mj_step(model, data, 500)
    assert data.joint("it_steering_joint").qpos[0] == pytest.approx(0.4, abs=1e-3)
    axle = data.body("it_link").xmat.reshape(3, 3)[:, 1]
    np.testing.assert_allclose(axle, [-np.sin(0.4), np.cos(0.4), 0], atol=2e-3)


CASTER = """links:
  base_link: {inertial: {mass: 3 kg, of: [box: {size: [0.3, 0.2, 0.08]}]}}
use:
  left: {part: wheels/fixed, parent: base_link, xyz: [0.1, 0.12, 0], with: {radius: 48 mm, width: 30 mm, mass: 0.2}}
  right: {part: wheels/fixed, parent: base_link, xyz: [0.1, -0.12, 0], with: {radius: 48 mm, width: 30 mm, mass: 0.2}}
  rear:
    part: wheels/caster
    parent: base_link
    xyz: [-0.12, 0, 12 mm]
    with: {radius: 20 mm, width: 20 mm, mass: 0.1, trail: 25 mm, height: 40 mm}
"""


@pytest.mark.parametrize("way", [1, -1])
def test_a_caster_swings_behind_the_way_it_rolls(tmp_path: Path, way: int) -> None:
    text = emitted(tmp_path, CASTER).replace(
        '<body name="base_link">', '<body name="base_link" pos="0 0 0.0485"><freejoint/>'
    )
    text = text.replace("<worldbody>", '<worldbody><geom type="plane" size="9 9 1"/>')
    motors = "".join(f'<velocity joint="{wheel}_joint" kv="0.5"/>' for wheel in ("left", "right"))
    model, data = load(text.replace("</mujoco>", f"<actuator>{motors}</actuator></mujoco>"))
    data.joint("rear_swivel").qpos[0] = 1.0
    data.ctrl[:] = 4.0 * way
    with no_warning():
        mujoco.mj_step(model, data, 2000)
    at = data.joint("rear_swivel").qpos[0]
    assert abs(np.angle(np.exp(1j * (at - (0 if way > 0 else np.pi))))) < 0.05


SERVO = """links:
  base_link: {}
  arm: {inertial: {mass: 0.1, of: [box: {min: [0, -0.01, -0.01], max: [0.2, 0.01, 0.01]}]}}
use:
  lift:
    part: servos/servo
    parent: base_link
    with: {child: arm, effort: 2 N*m, velocity: 4 rad/s, axis: [0, -1, 0], pulses: [500, 2500], angle: 180 deg, FLIPPED}
poses: {up: {pulses: {lift_joint: 2000}}, level: {pulses: {lift_joint: 1500}}}
"""


@pytest.mark.parametrize("flipped", [False, True])
def test_a_servo_turns_by_its_calibration_and_holds(tmp_path: Path, flipped: bool) -> None:
    text = SERVO.replace("FLIPPED", f"flipped: {str(flipped).lower()}")
    made = compiled(written(tmp_path, text))
    assert made.robot is not None
    (group,) = made.robot.servos
    assert (group.joints, group.zero_pulse, group.pulse_range) == (("lift_joint",), 1500, (500, 2500))
    sign = -1 if flipped else 1
    angle = made.robot.poses[1].positions["lift_joint"]
    assert angle == pytest.approx(sign * np.pi / 4)
    limit = made.robot.joint["lift_joint"].limit
    assert (limit.lower, limit.upper) == pytest.approx((-np.pi / 2, np.pi / 2))
    model, data = load(made.artifacts[0].text)
    data.ctrl[:] = angle
    fastest = 0.0
    with no_warning():
        for _ in range(1500):
            mujoco.mj_step(model, data)
            fastest = max(fastest, abs(data.qvel[0]))
    sag = 0.1 * GRAVITY * 0.1 * np.cos(angle) / (2 / np.radians(3))
    assert abs(data.qpos[0] - angle) < sag + np.radians(0.1)
    assert fastest < 4.4
    assert abs(data.qvel[0]) < 1e-3
