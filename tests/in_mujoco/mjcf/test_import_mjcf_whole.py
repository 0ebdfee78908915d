"""Whole models in the manner of public ones, imported: MuJoCo's model of the result is that of the source."""

import struct
import zlib
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main

pytest.importorskip("mujoco", minversion="4")
pytestmark = pytest.mark.slow

CORNER = (
    "v 0 0 0\nv 0.1 0 0\nv 0 0.2 0\nv 0 0 0.1\nv 0.06 0.06 0.06\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 5\nf 3 4 5\nf 4 2 5\n"
)
ARM = """
  <body name="base"><geom name="foot" type="box" size="0.1 0.1 0.1" mass="2"/>
    <body name="arm" pos="0 0 0.2">
      <joint name="turn" axis="0 1 0" range="-90 90" damping="0.5"/>
      <geom name="tube" type="capsule" size="0.02 0.1" mass="0.5"/>{arm}
      <body name="hand" pos="0 0 0.2">
        <joint name="grip" axis="0 1 0" range="-90 90"/>
        <geom name="tip" size="0.03" mass="0.1"/>{hand}
      </body>
    </body>
  </body>"""
SAME = "MuJoCo's model of the MJCF is that of the source"


def _png(path: Path) -> None:
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(range(row, row + 12)) for row in range(4))
    head = struct.pack(">IIBBBBB", 4, 4, 8, 2, 0, 0, 0)
    image = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + image)


@pytest.fixture(autouse=True)
def _files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("assets").mkdir()
    Path("assets/corner.obj").write_text(CORNER, "utf-8")
    _png(Path("assets/skin.png"))


def _model(more: str = "", arm: str = "", hand: str = "", world: str = "") -> str:
    before, _, after = more.partition("|")
    body = ARM.format(arm=arm, hand=hand)
    return f"""<mujoco model="whole"><compiler meshdir="assets" texturedir="assets"/>
{before}<worldbody>{world}{body}</worldbody>{after}</mujoco>"""


CASES = {
    "an image is that of its material": _model(
        '<asset><texture type="2d" name="skin" file="skin.png"/>'
        '<material name="painted" texture="skin" specular="0.1" texrepeat="2 2"/></asset>',
        '<geom type="box" size="0.05 0.05 0.05" mass="0" contype="0" conaffinity="0" material="painted"/>',
    ),
    "a cube of images is kept": _model(
        '<asset><texture type="cube" name="skin" file="skin.png"/>'
        '<material name="skin" texture="skin" texuniform="true"/></asset>',
        '<geom type="box" size="0.05 0.05 0.05" mass="0" contype="0" conaffinity="0" material="skin"/>',
    ),
    "layers of images are kept": _model(
        '<asset><texture type="2d" name="rgb" file="skin.png"/><texture type="2d" name="orm" file="skin.png"/>'
        '<material name="layered" rgba="1 0.5 0 1"><layer texture="rgb" role="rgb"/><layer texture="orm" role="orm"/>'
        "</material></asset>",
        '<geom type="box" size="0.05 0.05 0.05" mass="0" contype="0" conaffinity="0" material="layered"/>',
    ),
    "colours whose names end alike": _model(
        '<asset><material name="off_white" rgba="0.9 0.9 0.8 1"/><material name="white" rgba="1 1 1 1"/></asset>',
        '<geom size="0.05" mass="0" contype="0" conaffinity="0" material="white"/>',
        '<geom size="0.05" mass="0" contype="0" conaffinity="0" material="off_white"/>',
    ),
    "a mesh with a bound on its hull, one with smooth normals, one that is counted from elsewhere": _model(
        '<asset><mesh name="few" file="corner.obj" maxhullvert="4"/>'
        '<mesh name="smooth" file="corner.obj" smoothnormal="true"/>'
        '<mesh name="moved" file="corner.obj" scale="2 2 2" refpos="0.1 0 0" refquat="1 1 0 0"/></asset>',
        '<geom type="mesh" mesh="few" mass="0.1"/><geom type="mesh" mesh="moved" mass="0.1"/>',
        '<geom type="mesh" mesh="smooth" mass="0.1" pos="0.1 0 0"/><geom type="ellipsoid" mesh="few" pos="0 0.2 0"/>',
    ),
    "a coupling has a name of its own": _model(
        '|<equality><joint name="both" joint1="grip" joint2="turn" polycoef="0.1 -1 0 0 0"/></equality>'
    ),
    "what has a name that another would have by its place": _model(
        arm='<geom name="arm_collision_1" size="0.04" mass="0.1"/><geom name="hand_visual_2" size="0.05" mass="0.1"/>',
        hand='<geom size="0.04" mass="0.1"/><geom size="0.05" mass="0.1"/>',
    ),
    "a pair with the floor, which is kept": _model(
        '<asset><material name="ground" rgba="0.2 0.3 0.4 1"/></asset>'
        '|<contact><pair geom1="tip" geom2="floor" condim="4"/></contact>',
        world='<geom name="floor" type="plane" size="5 5 0.1" pos="0 0 -1" material="ground"/>',
    ),
    "in water, with several joints on a body": _model(
        '<option density="1000" viscosity="0.001"/>',
        '<body name="fin"><joint name="a"/><joint name="b" axis="1 0 0"/><joint name="c" axis="0 1 0"/>'
        '<geom type="ellipsoid" size="0.1 0.02 0.05" mass="0.2"/></body>',
    ),
    "a general actuator that is as strong as its range": _model(
        '|<actuator><general joint="turn" gainprm="40" ctrlrange="-1 1" dyntype="filter" dynprm="0.05"/></actuator>'
    ),
    "a motor of a class of servos that take the range of their joint": _model(
        '<default><default class="servo"><position kp="50" inheritrange="1"/></default></default>'
        '|<actuator><motor class="servo" joint="turn"/><position class="servo" joint="grip"/></actuator>'
    ),
    "numbers of which one would do": _model(
        '<option actuatorgroupdisable="2" o_friction="1 1 0.01 0.001 0.001"/>'
        '|<actuator><motor joint="turn" group="2"/></actuator>',
        '<site name="dot" size="0.02 0 0"/>',
    ),
    "a site that is a mesh, a body with a space in its name": _model(
        '<asset><mesh name="corner" file="corner.obj"/></asset>',
        '<site name="marked" type="mesh" mesh="corner"/>'
        '<camera name="eye" mode="targetbody" target="the end" ipd="0.1"/>'
        '<body name="the end"><geom size="0.01" mass="0.1"/></body>',
    ),
    "no XML to the letter": _model(arm='<!-- an arm -- of two --><geom name="b"size="0.01"type="sphere" mass="0.1"/>'),
}


@pytest.mark.parametrize("name", CASES)
def test_nothing_is_lost(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("whole.xml").write_text(CASES[name], "utf-8")
    assert main(["import", "whole.xml", "--strict", "--meshes", "../.."]) == 0
    said = "".join(capsys.readouterr())
    assert SAME in said
    assert "not carried over" not in said
    assert main(["all"]) == 0
    assert main(["check"]) == 0
