"""Importing the URDF, SDF and MJCF of our own robots restores sensors and drives as entries of the language."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

from rosorin_compile.cli.main import main
from support.paths import ROOT, ROSORIN
from support.robots import compiled

ROBOTS = [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]
FORMATS = ("urdf", "sdf", "mjcf")
QUICK = ("turtlebot3_burger-sdf", "porter-urdf")
CASES = [
    pytest.param(path, form, id=name, marks=() if name in QUICK else pytest.mark.slow)
    for path in ROBOTS
    for form in FORMATS
    for name in [f"{path.parent.name}-{form}"]
]


@cache
def artifacts(path: Path) -> list[tuple[str, str, str]]:
    return [(one.backend, one.file, one.text) for one in compiled(path).artifacts]


def in_artifact(text: str) -> tuple[int, int]:
    """Return the numbers of sensors and of drives that a file has."""
    root = ElementTree.fromstring(text)
    if root.tag == "mujoco":
        model = pytest.importorskip("mujoco").MjModel.from_xml_string(text)
        return model.nsensor + model.ncam, model.nu
    hardware = root.findall("ros2_control")
    joints = [
        joint for block in hardware for joint in block.iterfind("joint") if joint.find("command_interface") is not None
    ]
    sensors = [one for one in root.iter("sensor") if not any(one in block for block in hardware)]
    return len(sensors), len(joints)


def in_description(folder: Path) -> tuple[int, int]:
    """Return the numbers of sensors and of drives that the sections of a description have."""
    sections: dict[str, Any] = {}
    raw = ""
    for file in sorted(folder.glob("*.yaml")):
        for name, section in (yaml.safe_load(file.read_text("utf-8")) or {}).items():
            if isinstance(section, dict):
                sections.setdefault(name, {}).update(section)
            raw += " ".join(section) if name == "mjcf" else ""
    marks = [link.get("cameras") or {} for link in sections.get("links", {}).values() if link]
    # Of the elements of MuJoCo several may be one sensor.
    measured = list(sections.get("sensors", {}).values())
    sensors = sum(len(one.get("mjcf") or [one]) for one in measured) + sum(map(len, marks))
    sensors += raw.count("<actuatorfrc ")  # which no other format knows
    joints = [joint for block in sections.get("control", {}).values() for joint in block.get("joints", {}).values()]
    servos = [joint for joint in sections.get("joints", {}).values() if "actuator" in joint]
    drives = len([one for one in joints if one.get("command")]) + len(servos) + len(sections.get("actuators", {}))
    return sensors, drives


@pytest.mark.parametrize(("path", "form"), CASES)
def test_sensors_and_drives_are_entries_again(
    path: Path, form: str, home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [(file, text) for backend, file, text in artifacts(path) if backend == form]
    if not files:
        pytest.skip(f"{path.parent.name} has no {form}")
    for file, text in files:
        (home / file).write_text(text, "utf-8")
        code = main(["import", file, "-o", f"made_{file}", "--no-parts"])
        said = capsys.readouterr()
        assert code == 0, said.out + said.err
        assert in_description(home / f"made_{file}") == in_artifact(text), file
