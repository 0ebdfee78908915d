"""number_format: exact: what launch files publish is the description to the last digit, in every form of them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
)
from rosorin_compile.model.geometry import Transform
from rosorin_compile.ros.package.options import Options
from rosorin_compile.ros.package.package import make
from rosorin_compile.source.numbers import METRE_DIGITS, RADIAN_DIGITS, decimal
from support.launch import command_line, read, run
from support.schemas import schema

SCHEMA = schema("static_tf")
EXACT = {"number_format": "exact"}
FORMS = ("py", "xml", "yaml")

metres = st.floats(-100, 100)
radians = st.floats(-math.pi, math.pi)
poses = st.builds(Pose, st.tuples(metres, metres, metres), st.tuples(radians, radians, radians))
mounts = st.lists(poses, min_size=1, max_size=4)


def chain(mounted: list[Pose], options: dict[str, str]) -> Robot:
    """Return a chain of frames f0, f1, ...: by turns in the URDF and from a static_transform_publisher."""
    joints = []
    for at, pose in enumerate(mounted):
        for step, publisher in enumerate(
            (Publisher(ROBOT_STATE_PUBLISHER), Publisher(STATIC_TRANSFORM_PUBLISHER, f"tf_{at}"))
        ):
            parent, child = f"f{2 * at + step}", f"f{2 * at + step + 1}"
            joints.append(Joint(f"to_{child}", "fixed", parent, child, pose, publisher=publisher))
    outputs = (
        Output("urdf", "urdf", "r.urdf", EXACT),
        Output("static_tf", "static_tf", "r.launch.py", options),
        Output("static_tf_json", "static_tf_json", "r.json", options),
    )
    links = tuple(Link(f"f{at}") for at in range(2 * len(mounted) + 1))
    return Robot("chain", links, tuple(joints), outputs=outputs)


def emitted(robot: Robot) -> dict[str, Artifact]:
    """Return the artifacts of a robot by backend."""
    made = {}
    for output in robot.outputs:
        text, diagnostics = FORMATS[output.backend].write(robot, output, Templates())
        assert diagnostics == []
        made[output.backend] = Artifact(output.file, text, output.backend, output.name)
    return made


def in_urdf(text: str) -> dict[str, Pose]:
    """Return where the frames of a URDF are, by child, read by nothing of ours."""
    found = {}
    for element in ET.fromstring(text).iter("joint"):
        origin = element.find("origin")
        xyz, rpy = (tuple(map(float, origin.get(key, "0 0 0").split())) for key in ("xyz", "rpy"))
        found[element.find("child").get("link")] = Pose(xyz, rpy)
    return found


def published(arguments: list[list[str]]) -> dict[str, Pose]:
    """Return where frames are, by child, as static_transform_publisher reads its arguments."""
    return {child: pose for _, child, pose in map(command_line, arguments)}


def in_every_form(robot: Robot, made: dict[str, Artifact], folder: Path) -> list[dict[str, Pose]]:
    """Return what each form of the arguments says: the launch file, the JSON, the three launch files of a package."""
    listed = json.loads(made["static_tf_json"].text)
    jsonschema.validate(listed, SCHEMA)
    nodes = [node["arguments"] for node in listed["static_transform_publisher"]]
    text = made["static_tf"].text
    (folder / "r.urdf").write_text(made["urdf"].text)
    started = run(text, folder / "r.launch.py")
    found = [nodes, [node.arguments for node in started if node.executable == "static_transform_publisher"]]
    for name, data in make(robot, list(made.values()), Options("made"), (), folder)[0].items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    for form in FORMS:
        launch = read(folder / f"launch/description.launch.{form}", {"made": folder})
        found.append([node.arguments for node in launch.nodes if node.executable == "static_transform_publisher"])
    return [published(arguments) for arguments in found]


def composed(frames: dict[str, Pose]) -> Transform:
    """Return the last frame of a chain in its first."""
    whole = Transform()
    for at in range(1, len(frames) + 1):
        whole = whole.then(frames[f"f{at}"].transform())
    return whole


@pytest.mark.parametrize("options", [EXACT, {}], ids=["exact", "rounded"])
def test_arguments_compose_to_the_chain_of_the_model(tmp_path: Path, options: dict[str, str]) -> None:
    length, angle = (0, 0) if options else (0.5001 * 10**-METRE_DIGITS, 0.5001 * 10**-RADIAN_DIGITS)

    @given(mounts)
    @settings(max_examples=35, deadline=None)
    def holds(mounted: list[Pose]) -> None:
        robot = chain(mounted, options)
        made = emitted(robot)
        last = robot.links[-1].name
        wanted = robot.transform("f0", last, {})
        for found in in_every_form(robot, made, tmp_path):
            assert found.keys() == {joint.child for joint in robot.published_by(STATIC_TRANSFORM_PUBLISHER)}
            for child, said in found.items():
                assert said.xyz == pytest.approx(robot.joint_to[child].origin.xyz, rel=0, abs=length)
                assert said.rpy == pytest.approx(robot.joint_to[child].origin.rpy, rel=0, abs=angle)
            whole = composed({**in_urdf(made["urdf"].text), **found})
            assert whole.xyz == pytest.approx(wanted.xyz, abs=1e-9 if options else 1e-4)
        assert agreement(robot, list(made.values())) == []

    holds()


@given(poses, st.integers(0, 5), st.sampled_from([2e-9, -3e-8, 1e-3]))
@settings(max_examples=50, deadline=None)
def test_an_argument_that_is_off_by_a_digit_disagrees(pose: Pose, at: int, off: float) -> None:
    """Exact arguments are held against the model exactly, not to the digits that rounded ones have."""
    numbers = [*pose.xyz, *pose.rpy]
    assume(abs(math.cos(pose.rpy[1])) > 0.1 and abs(abs(numbers[at]) - math.pi) > 0.01)
    robot = chain([pose], EXACT)
    made = emitted(robot)["static_tf_json"]
    document = json.loads(made.text)
    arguments = document["static_transform_publisher"][0]["arguments"]
    arguments[2 * at + 1] = decimal(numbers[at] + off)
    assume(any(len(text.partition(".")[2]) > 8 for text in arguments[1:12:2]))
    assert agreement(robot, [replace(made, text=json.dumps(document))])


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_decimal_reads_back_and_has_no_exponent(value: float) -> None:
    text = decimal(value)
    assert float(text) == value
    assert set(text) <= set("-.0123456789")
    assert text != "-0"
    assert not text.endswith(".")
    assert "." not in text or not text.endswith("0")


def test_a_package_follows_the_data_where_there_is_no_launch_file(tmp_path: Path) -> None:
    pose = Pose((1 / 3, 0.0, 0.0))
    robot = chain([pose], EXACT)
    robot = replace(robot, outputs=tuple(o for o in robot.outputs if o.backend != "static_tf"))
    files, _ = make(robot, list(emitted(robot).values()), Options("made"), (), tmp_path)
    assert b"'--x', '0.3333333333333333'" in files["launch/description.launch.py"]
