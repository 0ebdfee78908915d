"""View as a person uses it: a process beside an editor that follows the files, and ends when it is told to."""

import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import jsonschema
import pytest
import yaml

from rosorin_compile.viewer.page import data_of
from support.commands import Shown, ask, write_files
from support.paths import ROOT, data_text
from support.robots import copy_of_rosorin
from support.schemas import schema
from support.viewing import Events, Viewing, asked

VALID = jsonschema.Draft7Validator(schema("page"))
# Seconds from a save to the event. A page has to be told within one; the rest is for a machine that is busy.
SOON = 3.0

SMALL = "robot: r\nlinks: {base: {}, arm: {}}\njoints: {j: {type: fixed, parent: base, child: arm, xyz: [1, 0, 0]}}\n"
PROJECT = {"descriptions/r/robot.yaml": SMALL}
ROBOT = Path("descriptions/r/robot.yaml")

pytestmark = pytest.mark.slow


def x_of_arm(view: Viewing) -> float:
    return float(view.robot["joints"][0]["xyz"][0])


def test_a_save_of_the_reference_robot_is_told_soon(home: Path) -> None:
    copy_of_rosorin(home)
    file = home / "descriptions/rosorin/lidar_and_imu.yaml"
    with Viewing(home, "--port", "0") as view, Events(view.port) as events:
        events.next()
        VALID.validate({"robot": view.robot})
        took = []
        for height in ("0.2067", "0.2068", "0.2069"):
            text = (ROOT / "descriptions/rosorin/lidar_and_imu.yaml").read_text("utf-8")
            file.write_text(text.replace("0.106748", height), "utf-8")
            begun = time.monotonic()
            assert events.next()[0] == "robot"
            took.append(time.monotonic() - begun)
            joint = next(one for one in view.robot["joints"] if one["child"] == "laser")
            assert joint["xyz"][2] == float(height)
        assert min(took) < SOON, took


def by_rename(path: Path, text: str) -> None:
    new = path.with_suffix(".new")
    new.write_text(text, "utf-8")
    new.replace(path)


def by_removal(path: Path, text: str) -> None:
    path.rename(path.with_suffix(".old"))
    time.sleep(0.02)
    path.write_text(text, "utf-8")


def in_place(path: Path, text: str) -> None:
    path.write_text(text, "utf-8")


@pytest.mark.parametrize("save", [by_rename, by_removal, in_place])
def test_however_an_editor_saves(project: Path, save: Callable[[Path, str], None]) -> None:
    with Viewing(project, "--port", "0") as view, Events(view.port) as events:
        events.next()
        for place in (2, 3):
            save(ROBOT, SMALL.replace("[1, 0, 0]", f"[{place}, 0, 0]"))
            while x_of_arm(view) != place:
                assert events.next()[0] in ("robot", "problem")


def test_an_error_is_told_with_its_place_and_the_robot_stays(project: Path) -> None:
    with Viewing(project, "--port", "0") as view, Events(view.port) as events:
        events.next()
        ROBOT.write_text(SMALL.replace("child: arm", "child: arn"))
        told = events.until("problem")["text"]
        assert f"{ROBOT}:3:" in told
        assert '"arn"' in told
        assert x_of_arm(view) == 1
        view.until('"arn"')
        ROBOT.write_text(SMALL.replace("[1, 0, 0]", "[4, 0, 0]"))
        assert events.until("robot")
        assert x_of_arm(view) == 4
        view.until("r: that is corrected")


def test_warnings_are_in_the_data_of_both_pages(project: Path, capsys: Shown) -> None:
    """With their place; on a page that is sent without the path of this machine."""
    ROBOT.write_text(SMALL.replace("xyz: [1, 0, 0]", "rpy: [0, 5, 0]"))
    with Viewing(project, "--port", "0") as view:
        VALID.validate({"robot": view.robot})
        (served,) = view.robot["warnings"]
    assert "[angle-looks-like-degrees]" in served["text"]
    assert served["where"]["path"] == str(project / ROBOT)
    ask(capsys, "view", "--html", "sent.html", str(project / "descriptions/r"))
    text = (project / "sent.html").read_text("utf-8")
    assert str(project) not in text
    (sent,) = data_of(text)["robot"]["warnings"]
    assert sent["text"] == served["text"]
    assert sent["where"] == {key: value for key, value in served["where"].items() if key != "path"}


def test_a_robot_with_errors_is_waited_for(project: Path) -> None:
    ROBOT.write_text("robot: r\nlinks: {base: {}, base: {}}\n")
    with Viewing(project, "--port", "0") as view, Events(view.port) as events:
        assert "yaml-duplicate" in events.until("problem")["text"] or "twice" in str(view.lines)
        status, content = view.get("/")
        assert status == 200
        assert b'id="robot">{"robot":null' in content
        assert view.robot is None
        VALID.validate({"robot": None})
        ROBOT.write_text(SMALL)
        events.until("robot")
        assert x_of_arm(view) == 1


CASES = yaml.safe_load(data_text("cases/view_live.yaml"))
FOREIGN = CASES["foreign"]


@pytest.mark.landing("outside", "a.xml")
@pytest.mark.parametrize("name", FOREIGN)
def test_robots_in_other_formats_are_followed_too(home: Path, name: str) -> None:
    if name.endswith("xacro"):
        pytest.importorskip("xacro")
    file = home / name
    file.write_text(FOREIGN[name].format(1))
    with Viewing(home, name, "--port", "0") as view, Events(view.port) as events:
        events.next()
        VALID.validate({"robot": view.robot})
        assert x_of_arm(view) == 1
        file.write_text(FOREIGN[name].format(2))
        events.until("robot")
        assert x_of_arm(view) == 2
        file.write_text("<robot")
        assert name in events.until("problem")["text"]


@pytest.mark.parametrize("text", [SMALL, FOREIGN["a.urdf"].format(1)], ids=["yaml", "urdf"])
def test_a_robot_from_standard_input_is_written_as_a_page(home: Path, text: str) -> None:
    command = [sys.executable, "-m", "rosorin_compile", "view", "-", "--html", "r.html"]
    ran = subprocess.run(command, cwd=home, input=text, capture_output=True, text=True, timeout=60, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    robot = data_of((home / "r.html").read_text("utf-8"))["robot"]
    assert [joint["child"] for joint in robot["joints"]] == ["arm"]


def test_a_mesh_is_served_under_its_number_and_followed(home: Path) -> None:
    """A mesh may be a link to elsewhere: the description names it."""
    text = "robot: r\nlinks: {base: {visual: [{mesh: {file: arm.stl}}]}}\n"
    write_files(home, {"descriptions/r/robot.yaml": text, "elsewhere/real.stl": "solid one"})
    mesh = home / "descriptions/r/arm.stl"
    with Viewing(home, "--port", "0") as view, Events(view.port) as events:
        events.next()
        assert "missing" in view.robot["meshes"]["arm.stl"]
        mesh.symlink_to(home / "elsewhere/real.stl")
        events.until("robot")
        first = view.robot["meshes"]["arm.stl"]["url"]
        VALID.validate({"robot": view.robot})
        assert view.get(f"/{first}") == (200, b"solid one")
        (home / "elsewhere/real.stl").write_text("solid another")
        events.until("robot")
        second = view.robot["meshes"]["arm.stl"]["url"]
        assert second != first
        assert view.get(f"/{second}") == (200, b"solid another")
        ROBOT.write_text("robot: r\nlinks: {base: {}}\n")
        events.until("robot")
        assert view.get(f"/{second}")[0] == 404, "the robot has it no more"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_at_once_while_pages_are_open(project: Path, number: int) -> None:
    with Viewing(project, "--port", "0") as view, Events(view.port) as one, Events(view.port) as other:
        one.next()
        other.next()
        begun = time.monotonic()
        assert view.end(number) == 0
        assert time.monotonic() - begun < SOON
        view.reader.join()
        assert [line for line in view.lines if line and "http://" not in line] == []


def test_only_this_machine_reaches_it_unless_somebody_says_so(project: Path) -> None:
    with Viewing(project, "--port", "0") as view:
        assert is_reached("127.0.0.1", view.port)
        assert not is_reached("127.0.0.2", view.port)
        assert asked(view.port, "/", Host=f"192.168.1.5:{view.port}")[0] == 403
    with Viewing(project, "--port", "0", "--host", "0.0.0.0") as view:  # noqa: S104
        view.until("every machine that reaches 0.0.0.0 sees this robot, its meshes and its sources")
        assert is_reached("127.0.0.2", view.port)


def is_reached(host: str, port: int) -> bool:
    try:
        socket.create_connection((host, port), timeout=5).close()
    except OSError:
        return False
    return True
