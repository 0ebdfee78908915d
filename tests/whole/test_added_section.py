"""A section that the schema alone knows: placed, told, compared and explained by what is said there."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.project import data_folder
from support.paths import PACKAGE

NAME = {"$ref": "#/$defs/name"}
BATTERY = {
    "type": "object",
    "description": "What the robot runs on.",
    "properties": {
        "voltage": {"type": "number", "description": "Its voltage.", "x-unit": "V"},
        "mass": {"type": "number", "description": "Its mass.", "x-unit": "kg"},
        "link": {**NAME, "description": "The link that it is in.", "x-names": "link", "x-attached": ["xyz"]},
        "gauge": {**NAME, "description": "What measures it.", "x-names": "sensor", "x-among": "description"},
        "spare": {**NAME, "description": "What stands in.", "x-names": "battery", "x-among": "description"},
        "xyz": {"$ref": "#/$defs/xyz"},
        "source": {"$ref": "#/$defs/source"},
    },
    "required": ["link"],
    "additionalProperties": False,
    "x-mirror": ["pose"],
    "x-accepted": ["{1}"],
}
SECTION = {
    "type": "object",
    "description": "Batteries, by name.",
    "propertyNames": {**NAME, "x-gives": "battery"},
    "additionalProperties": BATTERY,
    "x-in-parts": True,
    "x-merge": "entries",
    "x-called": "battery",
    "x-compared": "battery",
    "x-explained": True,
}
ROBOT = """\
robot: toy
links: {base: {}}
sensors: {meter: {type: imu, parent: base, frame: meter_frame}}
parts:
  pack:
    links: {box: {}}
    joints: {hold: {type: fixed, parent: mount, child: box, xyz: [0, 0.1, 0]}}
    battery:
      other: {link: mount, gauge: meter, spare: main}
      main: {link: box, voltage: 12, mass: 200 g, xyz: [0, 0.02, 0], source: {note: weighed, status: measured}}
use:
  left: {part: pack, parent: base}
  right: {part: pack, parent: base, mirror: y}
outputs: {urdf: {file: toy.urdf}}
"""


@pytest.fixture(scope="module")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package, whose schema has the section."""
    folder = tmp_path_factory.mktemp("tool")
    package = folder / PACKAGE.name
    package.mkdir()
    for one in PACKAGE.iterdir():
        (package / one.name).symlink_to(one)
    for data in ("templates", "parts_library", "schemas"):
        (package / data).unlink(missing_ok=True)
        if data != "schemas":
            (package / data).symlink_to(data_folder(data))
    (package / "schemas").mkdir()
    for one in data_folder("schemas").iterdir():
        (package / "schemas" / one.name).symlink_to(one)
    schema = package / "schemas" / "description.schema.json"
    said = json.loads(schema.read_text("utf-8"))
    said["properties"]["battery"] = SECTION
    schema.unlink()
    schema.write_text(json.dumps(said), "utf-8")
    return folder


def asked(tool: Path, folder: Path, *words: str, code: int = 0) -> str:
    """Return what a command says."""
    environment = {**os.environ, "PYTHONPATH": str(tool), "ROSORIN_COMPILE_CACHE": str(folder / "cache")}
    line = [sys.executable, "-m", PACKAGE.name, *words]
    done = subprocess.run(line, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return done.stdout + done.stderr


def described(folder: Path, old: str = "", new: str = "") -> str:
    """Write the robot with something else in it; return the name of its file."""
    assert old in ROBOT
    path = folder / ("toy.yaml" if not old else "other.yaml")
    path.write_text(ROBOT.replace(old, new) if old else ROBOT, "utf-8")
    return path.name


@pytest.mark.slow
def test_what_the_schema_says_is_enough(tool: Path, tmp_path: Path) -> None:
    robot = described(tmp_path)
    asked(tool, tmp_path, "all", robot)
    told = asked(tool, tmp_path, "diff", robot, described(tmp_path, "12", "24"), code=1)
    assert "battery left_main: voltage 12 -> 24\nbattery right_main: voltage 12 -> 24\ndifferent: 2 other" in told
    told = asked(tool, tmp_path, "diff", robot, described(tmp_path, "box", "tray"), code=1)
    assert "link left_box renamed to left_tray\nlink right_box renamed to right_tray\ndifferent: 2 names" in told
    told = asked(tool, tmp_path, "diff", robot, "outputs/toy/toy.urdf")
    assert "not compared: 4 batteries: outputs/toy/toy.urdf is a URDF, a format without a word for it" in told
    told = asked(tool, tmp_path, "diff", robot, described(tmp_path, "weighed", "guessed"))
    assert "the same robot" in told
    told = asked(tool, tmp_path, "all", described(tmp_path, "link: box", "link: bxo"), code=1)
    assert 'there is no link "bxo", the link of battery "left_main"' in told
    assert 'did you mean "box"?' in told
    told = asked(tool, tmp_path, "all", described(tmp_path, "meter, spare: main", "mteer, spare: mian"), code=1)
    assert 'there is no sensor "mteer", the gauge of battery "left_other"' in told
    assert 'did you mean "meter"?' in told
    assert 'there is no battery "mian", the spare of battery "left_other"' in told
    assert 'did you mean "main"?' in told
    told = asked(tool, tmp_path, "all", described(tmp_path, "battery:", "batery:"), code=1)
    assert 'did you mean "battery"?' in told
    told = asked(tool, tmp_path, "explain", robot, "right_main", "xyz", "mass")
    assert "toy.yaml:10:44  200 g" in told
    assert "-0.02 m" in told
