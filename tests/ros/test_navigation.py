"""Nav2 and robot_localization: what is written is what the description knows, and nodes would take it.

The robots of tests/data/navigation have their artifacts in ``outputs`` there, which are read by people and renewed by
``rosorin-compile all tests/data/navigation/NAME/robot.yaml -o tests/data/navigation/outputs/NAME``. The judges are
check --parameters, which reads files and tables by itself, and points of the shapes (test_footprint.py).
"""

import math
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot
from rosorin_compile.request import Request
from rosorin_compile.ros.check_parameters.check import check_parameters
from rosorin_compile.ros.navigation import FILTER, frames_of, kind_of
from rosorin_compile.ros.parameter_files import nodes_of
from rosorin_compile.ros.robot_localization import STATES
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.project import Description
from support.paths import DATA, ROOT, ROSORIN, data_text
from support.reading import leaves_of
from support.robots import compiled_text

CASES = yaml.safe_load(data_text("cases/navigation.yaml"))

FOLDER = DATA / "navigation"
NAMES = ("fetcher", "husky", "lopsided", "mule")
EMITTED = sorted((FOLDER / "outputs").glob("*/*.yaml"))
ROBOTS = [
    *(FOLDER / name / "robot.yaml" for name in NAMES),
    *sorted((DATA / "parameters").glob("*/robot.yaml")),
    ROSORIN,
    *sorted((ROOT / "examples").glob("*/robot.yaml")),
]
INPUTS = {"odom0": {"topic": "odom", "uses": ["vx", "vyaw"]}, "imu0": {"topic": "imu", "uses": ["vyaw"]}}


def of(path: Path) -> str:
    return f"{path.parent.parent.name}-{path.parent.name}"


def known(path: Path) -> Case:
    found = Request(Description(path.parent.name, path, Path("outputs"))).understand().case
    assert found is not None
    return found


def outputs(robot: Robot, distribution: str) -> Iterator[Output]:
    """Yield the outputs of a robot that has none of ours: one for Nav2, one for each filter."""
    yield Output("nav2", "nav2", "nav2.yaml", {"distribution": distribution})
    filters = [publisher.name for publisher in robot.publishers if kind_of(publisher) == FILTER]
    for name in filters or [""]:
        options = {"distribution": distribution, "inputs": INPUTS, **({"node": name} if name else {})}
        yield Output("robot_localization", "robot_localization", f"ekf{name}.yaml", options)


def written(robot: Robot, output: Output) -> str:
    text, said = FORMATS[output.backend].compile(robot, output, Templates())
    assert not has_errors(said), said
    return text


def looked_at(robot: Path, paths: list[Path], distribution: str) -> list[Diagnostic]:
    request = Request(Description(robot.parent.name, robot, Path("outputs")))
    return list(check_parameters(request, paths, distribution=distribution).diagnostics)


@pytest.mark.parametrize("name", NAMES)
def test_the_artifacts_are_those_that_people_have_read(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(["check", str(FOLDER / name / "robot.yaml"), "-o", str(FOLDER / "outputs" / name)])
    assert code == 0, capsys.readouterr().out


@pytest.mark.parametrize("distribution", ["humble", "jazzy"])
@pytest.mark.parametrize("path", ROBOTS, ids=of)
def test_what_is_written_is_sound_for_check_parameters(path: Path, distribution: str, tmp_path: Path) -> None:
    """Each file by itself and all together: no other node than the declared one publishes an edge."""
    robot = known(path)
    made = []
    for output in outputs(robot.robot, distribution):
        if frames_of(robot.robot, output)[0] is None:
            assert not any(
                edge.child in robot.robot.link for edge in robot.robot.edges if not edge.joint and edge.moving
            )
            return
        made.append(tmp_path / output.file)
        made[-1].write_text(written(robot.robot, output), "utf-8")
        assert looked_at(path, made[-1:], distribution) == []
    assert looked_at(path, made, distribution) == []


@pytest.mark.parametrize("text", ["a: [", "[1, 2]", "a: 1", "a: {b: {}}", "- a", ""])
@pytest.mark.parametrize("backend", ["nav2", "robot_localization"])
def test_a_damaged_artifact_is_an_error(backend: str, text: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        leaves_of(backend, text)


CAR = """robot: car
links:
  base_link: {{collision: [{{box: {{size: [0.4, 0.2, 0.1]}}}}]}}
  l: {{collision: [{{cylinder: {{radius: 50 mm, length: 20 mm}}, rpy: [90 deg, 0, 0]}}]}}
  r: {{collision: [{{cylinder: {{radius: 50 mm, length: 20 mm}}, rpy: [90 deg, 0, 0]}}]}}
  f: {{collision: [{{cylinder: {{radius: 50 mm, length: 20 mm}}, rpy: [90 deg, 0, 0]}}]}}
  fork: {{}}
  b: {{collision: [{{cylinder: {{radius: 50 mm, length: 20 mm}}, rpy: [90 deg, 0, 0]}}]}}
joints:
  l: {{type: continuous, parent: base_link, child: l, xyz: [{x}, 0.1, 0], axis: [0, 1, 0]}}
  r: {{type: continuous, parent: base_link, child: r, xyz: [{x}, -0.1, 0], axis: [0, 1, 0]}}
  fork: {{type: continuous, parent: base_link, child: fork, xyz: [0.3, 0.1, 0], axis: [0, 0, 1]}}
  f: {{type: continuous, parent: fork, child: f, axis: [0, 1, 0]}}
  b: {{type: continuous, parent: base_link, child: b, xyz: [0.3, -0.1, 0], axis: [0, 1, 0]}}
drive: {{{drive}}}
publishers: {{amcl: {{package: nav2_amcl}}, driver: {{package: car_driver}}}}
edges:
  - {{parent: odom, child: base_link, publisher: driver}}
  - {{parent: map, child: odom, publisher: amcl}}
outputs:
  nav2: {{file: nav2.yaml}}
  robot_localization:
    file: ekf.yaml
    inputs: {{odom0: {{topic: odom}}, imu0: {{topic: imu}}, twist0: {{topic: flow}}}}
"""


@pytest.mark.parametrize(("drive", "x", "uses", "model"), CASES["inputs_and_motion_follow_from_the_drive"])
def test_inputs_and_motion_follow_from_the_drive(tmp_path: Path, drive: str, x: float, uses: str, model: str) -> None:
    """A base that cannot go sideways has no speed sideways at its axle; elsewhere it has one as it turns."""
    made = compiled_text(tmp_path, CAR.format(drive=drive, x=x))
    assert not has_errors(made.diagnostics), made.diagnostics
    texts = {one.backend: yaml.safe_load(one.text) for one in made.artifacts}
    keys = texts["robot_localization"]["ekf_filter_node"]["ros__parameters"]
    assert [state for state, on in zip(STATES, keys["odom0_config"], strict=True) if on] == uses.split()
    assert keys["twist0_config"] == keys["odom0_config"]
    assert [state for state, on in zip(STATES, keys["imu0_config"], strict=True) if on] == ["vyaw"]
    assert keys["two_d_mode"] is True
    assert texts["nav2"]["amcl"]["ros__parameters"]["robot_model_type"].startswith(model)


def test_the_radius_holds_the_robot() -> None:
    """Of a radius a costmap makes a polygon of 16 corners that lies within the circle (nav2_costmap_2d)."""
    text = (FOLDER / "outputs" / "husky" / "nav2.yaml").read_text("utf-8")
    radius = nodes_of(text)["local_costmap/local_costmap"]["robot_radius"]
    way = math.pi / 16  # half-way between two corners
    farthest = math.hypot(0.49, 0.285)  # a corner of the base
    assert radius * math.cos(way) >= farthest - 1e-4
    assert radius < 1.05 * farthest


def test_a_mesh_of_another_format_is_not_measured_whatever_else_is_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("trimesh")
    pytest.importorskip("collada")
    shutil.copytree(FOLDER / "fetcher", tmp_path / "fetcher")
    shutil.copy(DATA / "factory_package" / "meshes" / "link2.dae", tmp_path / "fetcher")
    robot = tmp_path / "fetcher" / "robot.yaml"
    text = robot.read_text("utf-8").replace("shell.stl", "link2.dae")
    robot.write_text(f"{text}  mjcf: {{file: fetcher.xml}}\n", "utf-8")
    monkeypatch.chdir(tmp_path)
    made = []
    for more in ([], ["--only", "nav2"]):
        assert main(["all", "fetcher/robot.yaml", *more]) == 0
        said = capsys.readouterr().err
        assert "warning[nav2-footprint]: the size of link2.dae (link base_link) is unknown: footprint" in said
        made.append(next((tmp_path / "outputs").glob("*/nav2.yaml")).read_text("utf-8"))
    assert made[0] == made[1]
    assert "footprint:" not in made[0]


def test_without_a_table_of_its_own_a_later_distribution_is_as_jazzy() -> None:
    robot = known(FOLDER / "mule" / "robot.yaml").robot
    texts = [written(robot, Output("nav2", "nav2", "a.yaml", {"distribution": one})) for one in ("jazzy", "rolling")]
    jazzy, rolling = map(nodes_of, texts)
    # After Jazzy there is a node more.
    assert rolling.pop("route_server") == {"base_frame": "base_footprint", "route_frame": "map"}
    assert jazzy == rolling
    humble = written(robot, Output("nav2", "nav2", "a.yaml", {"distribution": "humble"}))
    assert "local_frame" in texts[0]
    assert "local_frame" not in humble
