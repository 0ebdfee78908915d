"""The page of a robot as an artifact: its data fit the schema, and check tells it by meaning."""

import json
import os
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Link, Output, Pose, Robot, Sensor
from rosorin_compile.model.robot import JointPose
from rosorin_compile.viewer.page import data_of, html
from rosorin_compile.viewer.page.data import robot_data
from rosorin_compile.viewer.page.images import companions
from support.paths import ROOT, ROSORIN, data_text
from support.robots import compiled, compiled_text, sound
from support.schemas import schema

VALID = jsonschema.Draft7Validator(schema("page"))
REAL = [ROSORIN, *sorted(ROOT.glob("examples/*/robot.yaml"))]

# Texts that end an element, a comment, a string or a line somewhere else.
SHARP = (
    "</script><script>document.title='out'</script>",
    "</SCRIPT ><img src=x onerror=alert(1)>",
    "<!--<script>",
    "]]>\u2028\u2029",
    "\"'`${x}\\",
    "</title><b>&lt;&amp;",
    "größer 机器人 \U0001f916 \u202e",
)


def page(robot: Robot, **options: Any) -> str:
    text, told = FORMATS["page"].compile(robot, Output("page", "page", "r.html", options), Templates(Path()))
    assert told == []
    return text


@pytest.mark.parametrize("path", REAL, ids=lambda path: path.parent.name)
def test_the_data_of_every_example_fit_the_schema(path: Path) -> None:
    robot = compiled(path).robot
    assert robot is not None
    VALID.validate(data_of(page(robot)))


class _Elements(HTMLParser):
    """What a parser of HTML finds: elements in their order, and the text in each."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.texts: list[str] = []
        self.comments = 0
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: object) -> None:  # noqa: ARG002
        self.tags.append(tag)
        self.texts.append("")

    def handle_data(self, data: str) -> None:
        if self.texts:
            self.texts[-1] += data

    def handle_comment(self, data: str) -> None:  # noqa: ARG002
        self.comments += 1


def sharp_robot(name: str) -> Robot:
    links = (Link("base"), Link(name))
    joint = Joint(f"j{name}", "revolute", "base", name, Pose((1.0, 2.0, 3.0)))
    sensors = (Sensor(name, name, name, joint.name),)
    return Robot(name, links, (joint,), sensors, poses=(JointPose(name, {joint.name: 0.5}),), modes=(name,))


@pytest.mark.parametrize("name", SHARP)
def test_no_name_breaks_out_of_the_page(name: str) -> None:
    robot = sharp_robot(name)
    text = page(robot)
    found, plain = _Elements(text), _Elements(page(sharp_robot("plain")))
    assert (found.tags, found.comments) == (plain.tags, plain.comments)
    assert found.tags.count("script") == 2
    assert found.texts[found.tags.index("title")].strip("\n") == name
    inside = found.texts[found.tags.index("script")]
    assert not set("<>&\u2028\u2029") & set(inside)
    assert json.loads(inside)["robot"]["links"][1]["name"] == name
    assert found.texts[-1] == plain.texts[-1], "the program is the same for every robot"


def test_the_page_asks_for_nothing() -> None:
    found = _Elements(page(sharp_robot("plain")))
    assert not {"link", "img", "iframe", "base", "object"} & set(found.tags)
    assert "default-src 'none'" in page(sharp_robot("plain"))
    assert "connect-src 'self'" in html({"robot": robot_data(sharp_robot("plain"))}, live="1")


SENSORS = data_text("robots/page_sensors.yaml")


def test_what_each_type_of_sensor_of_the_library_sees(tmp_path: Path) -> None:
    data = data_of(sound(compiled_text(tmp_path, SENSORS))[1]["page"])
    VALID.validate(data)
    sees = {sensor["name"]: sensor.get("sees", []) for sensor in data["robot"]["sensors"]}
    kinds = {name: [one["kind"] for one in found] for name, found in sees.items()}
    fans = {name: ["fan"] for name in ("lidar", "layers", "gazebo_only", "sonar")}
    axes = {name: ["axes"] for name in ("imu", "wrist")}
    eyes = {name: ["frustum"] for name in ("eye", "gazebo_eye")}
    assert kinds == {**fans, **axes, **eyes, "bumper": ["box"], "sky": []}
    lidar, sonar, layers = sees["lidar"][0], sees["sonar"][0], sees["layers"][0]
    assert (lidar["count"], lidar["range"], sonar["count"], sonar["range"]) == (5, 12, 1, 2)
    assert (lidar["first"], lidar["step"]) == pytest.approx((-1.570796326794897, 0.785398163397448))
    assert layers["layers"] == pytest.approx([-0.17453292519943, 0, 0.17453292519943], abs=1e-12)


def test_a_camera_of_mujoco_and_of_gazebo_look_the_same_way(tmp_path: Path) -> None:
    robot, texts, _ = sound(compiled_text(tmp_path, SENSORS))
    sees = {sensor["name"]: sensor.get("sees", []) for sensor in data_of(texts["page"])["robot"]["sensors"]}
    turned = []
    for name in ("eye", "gazebo_eye"):
        (seen,) = sees[name]
        assert (seen["hfov"], seen["vfov"]) == pytest.approx((1.570796326794897, 0.927295218001612), abs=1e-7)
        place = robot.pose_in_root(seen["frame"], {}).then(Pose(tuple(seen["xyz"]), tuple(seen["rpy"])).transform())
        turned.append(place)
        assert place.rotate((0.0, 0.0, 1.0)) == pytest.approx((1, 0, 0), abs=1e-9), "its z looks ahead"
        assert place.rotate((1.0, 0.0, 0.0)) == pytest.approx((0, -1, 0), abs=1e-9), "its x is right in the image"


PROJECT = {"descriptions/rover/robot.yaml": SENSORS}


# Images of a page: what materials and meshes name is shown if it is an image, within the limit, and nothing else.


PNG = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108020000009077"
    "53de0000000c49444154789c63f8cfc0000003010100c9fe92ef0000000049454e44ae426082"
)
DAE = """<COLLADA><library_images><image id="a"><init_from>{}</init_from></image></library_images>
<library_effects><surface><init_from>a</init_from></surface></library_effects></COLLADA>"""


HOMES = [
    pytest.param("descriptions/r/m.dae", "images/t.png", True, id="the project"),
    pytest.param("descriptions/r/m.dae", "../private/t.png", False, id="beside the project"),
    pytest.param("robot/meshes/visual/m.dae", "robot/textures/t.png", True, id="beside meshes"),
    pytest.param("robot/meshes/m.dae", "t.png", False, id="above the folder of meshes"),
    pytest.param("arm/share/deep/m.dae", "arm/t.png", True, id="in a package"),
    pytest.param("robot/m.dae", "t.png", False, id="above its folder"),
]


@pytest.mark.parametrize(("mesh", "image", "inside"), HOMES)
def test_an_image_is_in_the_project_of_its_mesh(tmp_path: Path, mesh: str, image: str, inside: bool) -> None:
    top = tmp_path / "top"
    for file in (top / mesh, top / image, top / "arm" / "package.xml"):
        file.parent.mkdir(parents=True, exist_ok=True)
    (top / "arm" / "package.xml").write_text("<package><name>arm</name></package>", "utf-8")
    (top / image).write_bytes(PNG)
    asked = os.path.relpath(top / image, (top / mesh).parent)
    (top / mesh).write_text(DAE.format(asked), "utf-8")
    (top / mesh).with_suffix(".obj").write_text(f"mtllib {asked}.mtl\n", "utf-8")
    (top / f"{image}.mtl").write_text("newmtl a\nmap_Kd t.png\n", "utf-8")
    assert len(companions(top / mesh)[0]) == inside
    assert len(companions((top / mesh).with_suffix(".obj"))[0]) == inside
    vain = companions(top / mesh)[1]
    assert vain == ({} if inside else {"t.png": "a mesh names it outside of the project"})


def test_a_link_leads_to_no_image_outside(tmp_path: Path) -> None:
    """A folder that ``colcon build --symlink-install`` made is one of links, to files of the source."""
    source, installed, private = tmp_path / "src", tmp_path / "install", tmp_path / "private"
    for folder in (source, installed, private):
        (folder / "meshes").mkdir(parents=True)
    (source / "package.xml").write_text("<package><name>arm</name></package>", "utf-8")
    (source / "meshes/t.png").write_bytes(PNG)
    (private / "t.png").write_bytes(PNG)
    (source / "meshes/m.dae").write_bytes(DAE.format("t.png").encode())
    for name in ("meshes/m.dae", "meshes/t.png"):
        (installed / name).symlink_to(source / name)
    mesh = installed / "meshes/m.dae"
    assert len(companions(mesh)[0]) == 1
    (installed / "meshes/t.png").unlink()
    (installed / "meshes/t.png").symlink_to(private / "t.png")
    assert companions(mesh)[0] == []
