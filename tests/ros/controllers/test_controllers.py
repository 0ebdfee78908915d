"""controllers.yaml: what the robot knows is filled in, and what comes out is what rcl and the controllers take.

A robot is a file of tests/data/controllers; what is to be written of it stands in ``expected``, by distribution.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile import check_parameters
from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import NOTE, has_errors
from rosorin_compile.source.project import Description
from support.commands import parse
from support.paths import DATA, data_text

FOLDER = DATA / "controllers"
ROBOTS = sorted(path.stem for path in FOLDER.glob("*.yaml"))
WRITTEN = [(name, one) for name in ROBOTS for one in ("humble", "jazzy") if (name, one) != ("omni", "humble")]


def compiled(path: Path, distribution: str) -> CompileResult:
    made = compile_robot(path, {"distribution": distribution})
    assert not has_errors(made.diagnostics), [one.message for one in made.diagnostics]
    return made


def changed(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    text = (FOLDER / f"{name}.yaml").read_text("utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    return path


def parameters(path: Path, distribution: str = "jazzy") -> Mapping[str, Any]:
    text = compiled(path, distribution).artifacts[0].text
    return {name: node.get("ros__parameters", node) for name, node in yaml.safe_load(text).items()}


def held(robot: Path, file: Path, *words: str) -> list[str]:
    options = parse(["check", "parameters", str(robot), "--controllers", str(file), *words])
    request = Request(Description("robot", robot, Path("outputs")))
    result = check_parameters(request, [], controllers=[file], remaps=options.remap, distribution=options.distribution)
    assert result.robot
    return [one.message for one in result.diagnostics]


@pytest.mark.parametrize(("name", "distribution"), WRITTEN)
def test_the_text(name: str, distribution: str) -> None:
    text = compiled(FOLDER / f"{name}.yaml", distribution).artifacts[0].text
    assert text == (FOLDER / "expected" / f"{name}.{distribution}.yaml").read_text("utf-8")


@pytest.mark.parametrize(("name", "distribution"), WRITTEN)
def test_nothing_is_said_of_what_is_written(name: str, distribution: str) -> None:
    remap = ["--remap", "~/tf_odometry:=/tf"]
    file = FOLDER / "expected" / f"{name}.{distribution}.yaml"
    assert held(FOLDER / f"{name}.yaml", file, "--distribution", distribution, *remap) == []


EDGE = "edges: [{parent: odom, child: base_footprint, publisher: wheels}]\n"
PUBLISHERS = "publishers: {wheels: {package: mecanum_drive_controller}}\n"


@pytest.mark.parametrize(
    ("changes", "publishes"),
    [
        ([], True),
        (
            [
                (PUBLISHERS, "publishers: {ekf: {package: robot_localization}}\n"),
                ("publisher: wheels}", "publisher: ekf}"),
            ],
            False,
        ),
        (
            [(PUBLISHERS, "publishers: {base: {package: ros2_control}}\n"), ("publisher: wheels}", "publisher: base}")],
            True,
        ),
        ([(PUBLISHERS + EDGE, "")], False),
    ],
    ids=["its own", "of the filter", "by its package", "of nobody"],
)
def test_the_declared_owner_publishes_and_nobody_else(
    tmp_path: Path, changes: list[tuple[str, str]], publishes: bool
) -> None:
    path = changed(tmp_path, "mecanum", *changes)
    assert parameters(path)["wheels"]["enable_odom_tf"] is publishes
    told = {one.rule for one in compile_robot(path).diagnostics if one.severity == NOTE}
    assert ("controllers-remap" in told) == publishes
    assert ("controllers-odometry" in told) == (PUBLISHERS + EDGE in [old for old, _ in changes])


def test_frames_are_those_of_the_description_in_a_namespace_too(tmp_path: Path) -> None:
    path = changed(tmp_path, "mecanum", ('"${distribution}"}', '"${distribution}", namespace: left}'))
    wheels = parameters(path)["left"]["wheels"]["ros__parameters"]
    frames = {key: wheels[key] for key in ("odom_frame_id", "base_frame_id", "tf_frame_prefix_enable")}
    assert frames == {"odom_frame_id": "odom", "base_frame_id": "base_footprint", "tf_frame_prefix_enable": False}


@pytest.mark.parametrize(("state", "feedback"), [("position", True), ("velocity", None)])
def test_a_steered_base_reads_what_its_wheels_measure(tmp_path: Path, state: str, feedback: bool | None) -> None:
    joints = [f"rear_{side}_joint: {{command: velocity, state: {state}}}" for side in ("left", "right")]
    joints += [f"{side}_steer: {{command: position, state: position}}" for side in ("left", "right")]
    control = f"control: {{motors: {{plugin: a/B, joints: {{{', '.join(joints)}}}}}}}"
    path = changed(tmp_path, "ackermann", ("controllers: {base", f"{control}\ncontrollers: {{base"))
    assert parameters(path)["base"].get("position_feedback") is feedback


def test_a_prefix_of_frames_is_not_in_the_description(tmp_path: Path) -> None:
    wheels = "wheels: {type: mecanum_drive, params: {tf_frame_prefix_enable: true}}"
    space = ('"${distribution}"}', '"${distribution}", namespace: left}')
    made = compile_robot(changed(tmp_path, "mecanum", ("wheels: {type: mecanum_drive}", wheels), space))
    assert [one.rule for one in made.diagnostics if has_errors([one])] == ["parameters-other-edge"]


def test_a_broadcaster_of_a_gnss_gets_its_sensor(tmp_path: Path) -> None:
    lines = "sensors: {gps: {type: gnss, parent: base_link, frame: gps_link}}\ncontrollers:\n"
    path = changed(tmp_path, "differential", ("controllers:\n", f"{lines}  fix: {{type: gps_sensor_broadcaster}}\n"))
    assert parameters(path)["fix"] == {"sensor_name": "gps", "frame_id": "gps_link"}


def test_numbers_are_doubles_where_the_controller_wants_them(tmp_path: Path) -> None:
    path = changed(tmp_path, "differential", ("publish_rate: 50", "publish_rate: 50, velocity_rolling_window_size: 5"))
    base = parameters(path)["base"]
    assert (type(base["publish_rate"]), type(base["velocity_rolling_window_size"])) == (float, int)


def test_what_is_said_wins_over_what_is_known(tmp_path: Path) -> None:
    path = changed(tmp_path, "differential", ("publish_rate: 50", "wheel_separation: 31 cm"))
    assert parameters(path)["base"]["wheel_separation"] == 0.31


def test_texts_stay_texts(tmp_path: Path) -> None:
    path = changed(tmp_path, "arm", ("interface_name: velocity", "interface_name: 'on'"))
    assert 'interface_name: "on"' in compiled(path, "jazzy").artifacts[0].text


def test_in_a_part_the_names_have_its_prefix(tmp_path: Path) -> None:
    (tmp_path / "side.yaml").write_text(data_text("robots/controllers_side.yaml"), "utf-8")
    path = tmp_path / "robot.yaml"
    path.write_text(
        """robot: two
args: {distribution: {type: text, default: jazzy}}
include: [side.yaml]
links: {base_link: {}}
use:
  left: {part: side, parent: base_link, prefix: left_}
  right: {part: side, parent: base_link, prefix: right_, xyz: [0, 1, 0]}
outputs: {controllers: {file: c.yaml}}
""",
        "utf-8",
    )
    nodes = parameters(path)
    assert nodes["left_moves"]["joints"] == ["left_shoulder"]
    assert nodes["right_moves"]["gains"] == {"right_shoulder": {"p": 2.0}}


def test_a_controller_before_another_one_claims_nothing_of_its_joints(tmp_path: Path) -> None:
    params = "{dof_names: [JOINT], command_interface: effort, reference_and_state_interfaces: [velocity]}"
    pid = f"{{type: pid, params: {params}}}"
    wheels = ("front_left", "left", "front_right", "right")
    chain = "".join(f"  {name}_pid: {pid.replace('JOINT', name)}\n" for name in wheels)
    sides = "left_wheel_names: [front_left_pid/front_left, left_pid/left]"
    sides += ", right_wheel_names: [front_right_pid/front_right, right_pid/right]"
    robot = changed(
        tmp_path,
        "differential",
        ("controllers:\n  base:", f"controllers:\n{chain}  base:"),
        ("cmd_vel_timeout: 0.5", f"cmd_vel_timeout: 0.5, {sides}"),
    )
    assert parameters(robot)["base"]["left_wheel_names"] == ["front_left_pid/front_left", "left_pid/left"]
