"""Reading URDF: defaults, numbers, encodings, comments, what is kept, and files that are none."""

from __future__ import annotations

import codecs
import math
import os
from pathlib import Path

import pytest

from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.source.diagnostics import ERROR
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.tree import Map
from rosorin_compile.source.units import Quantity
from support.importing import urdf_of

LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'


def read(folder: Path, text: str | bytes, name: str = "robot.urdf", lenient: bool = False) -> Imported:
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_robot(path, ReadOptions(lenient=lenient))


def tree_of(folder: Path, text: str | bytes) -> Map:
    imported = read(folder, text)
    assert imported.tree is not None, report(arrange(imported.diagnostics))
    return imported.tree


def joint_of(folder: Path, inner: str, kind: str = "revolute", extra: str = "") -> Map:
    text = f'<robot name="r"><link name="a"/><link name="b"/><link name="c"/>{extra}<joint name="j" type="{kind}">'
    text += f'<parent link="a"/><child link="b"/>{inner}</joint>'
    text += '<joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint></robot>'
    return tree_of(folder, text)["joints"]["j"]


def link_of(folder: Path, inner: str, extra: str = "") -> Map:
    return tree_of(folder, f'<robot name="r"><link name="a">{inner}</link>{extra}</robot>')["links"]["a"]


def told(imported: Imported) -> list[str]:
    return [f"{d.severity}[{d.rule}]: {d.message}" for d in arrange(imported.diagnostics)]


def test_defaults_of_a_joint(tmp_path):
    joint = joint_of(tmp_path, '<limit effort="1" velocity="2" upper="0.5"/><mimic joint="k"/><origin/>')
    assert joint == {
        "type": "revolute",
        "parent": "a",
        "child": "b",
        "limit": {"upper": 0.5, "lower": 0, "effort": 1, "velocity": 2},
        "mimic": {"joint": "k"},
    }


def test_continuous_joint_has_no_ends_by_default(tmp_path):
    assert joint_of(tmp_path, '<limit effort="1" velocity="2"/>', "continuous")["limit"] == {"effort": 1, "velocity": 2}


def test_everything_of_a_joint(tmp_path):
    inner = '<safety_controller k_velocity="3" soft_upper_limit=".5"/><dynamics friction="+1" damping="1."/>'
    inner += f'<calibration falling="-0"/><axis xyz="0 0 -1"/><origin rpy=".1 0 1e-3"/>{LIMIT}<my_own a="1"/>'
    joint = joint_of(tmp_path, inner)
    assert joint["safety_controller"] == {"soft_upper_limit": 0.5, "k_velocity": 3}
    assert joint["dynamics"] == {"damping": 1, "friction": 1}
    assert joint["calibration"] == {"falling": 0}
    assert (joint["axis"], joint["rpy"]) == ([0, 0, -1], [0.1, 0, 0.001])
    assert joint["urdf_elements"] == ['<my_own a="1"/>']


def test_fixed_joint_keeps_safety_and_calibration(tmp_path):
    inner = f'<axis xyz="0 0 0"/>{LIMIT}<calibration rising="1"/><safety_controller k_velocity="1"/>'
    joint = joint_of(tmp_path, inner, "fixed")
    assert set(joint) == {"type", "parent", "child", "calibration", "safety_controller"}


@pytest.mark.parametrize("word", ["1e-3", ".5", "+1", "1.", "-0", "1E+2", "-.5e-1", "007", "0.1000"])
def test_numbers(tmp_path, word):
    assert joint_of(tmp_path, f'{LIMIT}<origin xyz="{word} 0 0"/>').get("xyz") == [float(word), 0, 0]


def test_angles_and_lengths_beyond_any_robot_are_quantities(tmp_path):
    limit = '<limit lower="-6.5" upper="12.566370" effort="1" velocity="1"/>'
    joint = joint_of(tmp_path, f'{limit}<origin xyz="160 0 0" rpy="0 0 90"/>')
    found = [joint["limit"]["lower"], joint["limit"]["upper"], joint["xyz"][0], joint["rpy"][2]]
    assert all(isinstance(value, Quantity) for value in found)
    assert [value.text for value in found] == ["-6.5 rad", "12.566370 rad", "160 m", "90 rad"]
    assert found == [-6.5, 12.56637, 160, 90]
    span = joint["limit"].value_spans["upper"]
    assert span.source.line(span.line)[span.column - 1 :][: span.length] == "12.566370"


@pytest.mark.parametrize("separator", ["   ", "\t", "\n", "&#32;", "&#9;"])
def test_vectors_are_split_at_any_white_space(tmp_path, separator):
    assert joint_of(tmp_path, f'{LIMIT}<origin xyz=" 1{separator}2{separator}3 "/>')["xyz"] == [1, 2, 3]


def test_quaternion_becomes_rpy(tmp_path):
    half = math.sqrt(0.5)
    joint = joint_of(tmp_path, f'{LIMIT}<origin xyz="1 2 3" quat_xyzw="0 0 {2 * half} {2 * half}"/>')
    assert joint["xyz"] == [1, 2, 3]
    assert joint["rpy"] == pytest.approx([0, 0, math.pi / 2], abs=1e-15)


def test_everything_of_a_link(tmp_path):
    inner = '<collision><geometry><sphere radius="1"/></geometry></collision><visual name="one"><geometry>'
    inner += '<mesh filename="package://p/a b.stl" scale="1 2 3"/></geometry><material name="red"/></visual>'
    inner += '<visual><material name="own"><texture filename="t.png"/><color rgba="0 0 1 .5"/></material>'
    inner += '<geometry><capsule radius="1" length="2"/></geometry><origin xyz="0 0 1"/></visual><extra/>'
    inner += '<inertial><inertia ixx="1" iyy="2" izz="2.5" ixy="0" ixz="0" iyz="0"/><mass value="4"/></inertial>'
    link = link_of(tmp_path, inner, '<material name="red"><color rgba="1 0 0 1"/></material>')
    assert link["collision"] == [{"sphere": {"radius": 1}}]
    first, second = link["visual"]
    assert first == {"mesh": {"file": "package://p/a b.stl", "scale": [1, 2, 3]}, "name": "one", "material": "red"}
    assert (second["material"], second["texture"], second["rgba"]) == ("own", "t.png", [0, 0, 1, 0.5])
    assert (second["capsule"], second["xyz"]) == ({"radius": 1, "length": 2}, [0, 0, 1])
    assert link["inertial"]["mass"] == 4
    assert link["urdf_elements"] == ["<extra/>"]


def test_geometry_of_another_kind_is_kept_whole(tmp_path):
    plane = '<collision name="c"><geometry><plane normal="0 0 1"/></geometry></collision>'
    link = link_of(tmp_path, f'<visual><geometry><box size="1 1 1"/></geometry></visual>{plane}')
    assert link["urdf_elements"] == [plane]
    assert "collision" not in link


def test_same_name_with_another_look_loses_the_name(tmp_path):
    solid = '<visual><geometry><sphere radius="1"/></geometry>'
    solid += '<material name="m"><color rgba="{} 0 0 1"/></material></visual>'
    imported = read(tmp_path, f'<robot name="r"><link name="a">{solid.format(1)}{solid.format(0)}</link></robot>')
    assert imported.tree is not None
    first, second = imported.tree["links"]["a"]["visual"]
    assert (first["material"], first["rgba"]) == ("m", [1, 0, 0, 1])
    assert ("material" in second, second["rgba"]) == (False, [0, 0, 0, 1])
    assert [one.rule for one in imported.diagnostics] == ["import-changed"]


def test_names_of_materials_and_shapes_that_no_description_can_have(tmp_path):
    solid = '<visual name="it&apos;s"><geometry><sphere radius="1"/></geometry><material name=" dark  red "/></visual>'
    material = '<material name=" dark  red "><color rgba="1 0 0 1"/></material>'
    imported = read(tmp_path, f'<robot name="r"><link name="a">{solid}</link>{material}</robot>')
    assert imported.tree is not None
    assert imported.tree["links"]["a"]["visual"] == [{"material": "dark red", "sphere": {"radius": 1}}]
    assert list(imported.tree["materials"]) == ["dark red"]
    assert [line.split(":")[0] for line in told(imported)] == [
        "warning[import-cannot-carry]",
        "note[import-changed]",
        "note[import-changed]",
    ]


def test_kept_elements_declare_their_prefixes(tmp_path):
    text = '<robot name="r" xmlns:sim="http://s.invalid" xmlns:other="http://o.invalid"><link name="a"/>\n'
    text += '    <sim:part b="1">\n      <undeclared:x/>\n    </sim:part>\n</robot>'
    tree = tree_of(tmp_path, text)
    assert tree["urdf_elements"] == ['<sim:part xmlns:sim="http://s.invalid" b="1">\n  <undeclared:x/>\n</sim:part>']
    assert "undeclared:x" in urdf_of(tree)


def test_names_of_real_robots(tmp_path):
    text = '<robot name="größe 1"><link name="ns/base link"/><link name="机器人"/><joint name="机器人" type="fixed">'
    text += '<parent link="ns/base link"/><child link="机器人"/></joint></robot>'
    tree = tree_of(tmp_path, text)
    assert tree["robot"] == "größe 1"
    assert list(tree["links"]) == ["ns/base link", "机器人"]
    span = tree["joints"].key_spans["机器人"]
    assert span.source.line(span.line)[span.column - 1 :][: span.length] == "机器人"


COMMENTS = """<?xml version="1.0"?>
<!-- made by hand -->
<robot name="r"> <!-- a robot -->
  <!-- where it begins -->
  <link name="a"/> <!-- the base -->
  <joint name="j" type="fixed">
    <!-- glued -->
    <parent link="a"/>
    <!-- above -->
    <child link="b"/>
    <!-- nothing more -->
  </joint>
  <!-- for the simulator -->
  <gazebo><!-- inside --></gazebo>
  <link name="b"/>
  <!-- last -->
</robot>
<!-- the end -->
"""


def test_comments_belong_to_what_they_stand_at(tmp_path):
    found = [(c.text.strip(), c.span.line, c.path, c.where) for c in read(tmp_path, COMMENTS).comments]
    assert found == [
        ("made by hand", 2, ("robot",), "before"),
        ("a robot", 3, ("robot",), "beside"),
        ("where it begins", 4, ("links", "a"), "before"),
        ("the base", 5, ("links", "a"), "beside"),
        ("glued", 7, ("joints", "j", "parent"), "before"),
        ("above", 9, ("joints", "j", "child"), "before"),
        ("nothing more", 11, ("joints", "j"), "inside"),
        ("for the simulator", 13, ("urdf_elements", 0), "before"),
        ("last", 16, ("robot",), "inside"),
        ("the end", 18, (), "end"),
    ]


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-16", "utf-16-le", "utf-16-be", "iso-8859-1", "windows-1252", "utf-8-sig"]
)
def test_encodings(tmp_path, encoding):
    declared = encoding.removesuffix("-sig").removesuffix("-le").removesuffix("-be")
    text = f'<?xml version="1.0" encoding="{declared}"?><robot name="r"><link name="größe"/></robot>'
    assert list(tree_of(tmp_path, text.encode(encoding))["links"]) == ["größe"]


def test_marks_without_declaration(tmp_path):
    text = '<robot name="r"><link name="größe"/></robot>'
    marked = codecs.BOM_UTF32_LE + text.encode("utf-32-le")
    assert list(tree_of(tmp_path, marked)["links"]) == ["größe"]
    assert list(tree_of(tmp_path, codecs.BOM_UTF8 + text.replace("><", ">\r\n<").encode())["links"]) == ["größe"]


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "error[file-empty]: robot.urdf is empty"),
        (b" \n\t", "error[file-empty]: robot.urdf is empty"),
        (b"\x7fELF\0\0\1\2", "error[not-text]: robot.urdf is not a text file: it contains zero bytes"),
        (b"solid cube\nfacet normal 0 0 1\n", "error[wrong-format]: robot.urdf is not XML"),
        (b"<!DOCTYPE html>\n<html></html>", "error[wrong-root]: robot.urdf is a web page, not a robot"),
        (
            b"version https://git-lfs.github.com/spec/v1\n",
            "error[wrong-format]: robot.urdf is a pointer of Git LFS, not the file itself",
        ),
        (b'<robot name="\xf6"/>', "error[not-utf8]: robot.urdf is not UTF-8 text: byte 0xf6 at this place"),
        (
            b'<?xml version="1.0" encoding="utf-16"?><robot/>',
            'error[not-utf8]: robot.urdf declares the encoding "utf-16", which is unknown or not its own',
        ),
        (
            b'<?xml version="1.0" encoding="rot13"?><robot/>',
            'error[not-utf8]: robot.urdf declares the encoding "rot13", which is unknown or not its own',
        ),
        (
            b'<?xml version="1.0" encoding="unicode_escape"?><robot/>',
            'error[not-utf8]: robot.urdf declares the encoding "unicode_escape", which is unknown or not its own',
        ),
    ],
)
def test_files_that_are_no_robot(tmp_path, monkeypatch, data, message):
    monkeypatch.chdir(tmp_path)
    assert told(read(Path(), data)) == [message]


def test_paths_that_are_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("folder.urdf").mkdir()
    os.mkfifo("pipe.urdf")
    for name in ("folder.urdf", "pipe.urdf", "none.urdf", "a\0b.urdf"):
        assert [one.rule for one in read_robot(Path(name)).diagnostics] == ["file-unreadable"]
    assert [one.rule for one in read_robot(Path("robot.yaml")).diagnostics] == ["wrong-format"]


def test_external_entity_is_not_read(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("secret words", "utf-8")
    text = f'<!DOCTYPE robot [<!ENTITY s SYSTEM "{secret.as_uri()}">]><robot name="r"><link name="&s;"/></robot>'
    (diagnostic,) = read(tmp_path, text).diagnostics
    assert (diagnostic.rule, diagnostic.severity) == ("xml-doctype", ERROR)
    assert "secret words" not in report([diagnostic])


def test_deep_and_wide_files_end(tmp_path):
    assert told(read(tmp_path, "<a>" * 100_000))[0].startswith("error[xml-too-deep]")
    ends = '<parent link="l0"/><child link="l{0}"/>'
    one = f'<link name="l{{0}}"/><joint name="j{{0}}" type="fixed">{ends}</joint>'
    many = "".join(one.format(n) for n in range(1, 400))
    assert len(tree_of(tmp_path, f'<robot name="r"><link name="l0"/>{many}</robot>')["links"]) == 400


def test_format_is_found_by_content(tmp_path):
    text = '<robot name="r"><link name="a"/></robot>'
    assert read(tmp_path, text, "robot.xml").tree is not None
    assert read(tmp_path, text, "robot.xacro").diagnostics == []  # nothing to expand: nothing is run
