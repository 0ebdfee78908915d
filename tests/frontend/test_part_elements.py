"""Elements of XML in parts and sensors: the names in them follow their prefixes, and no value breaks them."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.language.element_names import renamed
from rosorin_compile.source.diagnostics import text as report
from rosorin_compile.source.xml.elements import damage, fitted
from support.robots import compiled_text

WHEEL = """robot: cart
links: {base_link: {}, wheel: {}}
joints: {wheel_joint: {type: fixed, parent: base_link, child: wheel}}
parts:
  wheel:
    links:
      wheel:
        urdf_elements: [<contact link="wheel" other="wheel"/>]
        visual: [{sphere: {radius: 1}, urdf_elements: [<a joint="wheel_joint"/>]}]
    joints:
      wheel_joint:
        {type: continuous, parent: mount, child: wheel, axis: [0, 1, 0], urdf_elements: [<b link1="wheel"/>]}
    urdf_elements:
      - |
        <gazebo reference="wheel"><kp>1</kp><sensor name="wheel" type="wheel"/></gazebo>
        <!-- wheel -->
        <gazebo reference="mount"/>
      - <ros2_control name="wheel" prefix="${prefix}"><joint name="wheel_joint"><param name="wheel">wheel</param>
        <param name="mimic">wheel_joint</param></joint></ros2_control>
      - <gazebo><plugin name="p" filename="wheel"><left_joint>wheel_joint</left_joint>
        <topic>wheel</topic></plugin></gazebo>
  axle:
    use:
      left: {part: wheel, parent: mount}
      right: {part: wheel, parent: mount, mirror: y}
use:
  front: {part: axle, parent: base_link}
  plain: {part: wheel, parent: front_left_wheel, prefix: ""}
outputs: {urdf: {file: cart.urdf}}
"""


def urdf(folder, text):
    made = compiled_text(folder, text)
    (artifact,) = [one for one in made.artifacts if one.backend == "urdf"] or pytest.fail(report(made.diagnostics))
    return ET.fromstring(artifact.text)


def test_names_in_elements_follow_all_prefixes(tmp_path):
    robot = urdf(tmp_path, WHEEL.replace("links: {base_link: {}, wheel: {}}", "links: {base_link: {}}").replace(
        "joints: {wheel_joint: {type: fixed, parent: base_link, child: wheel}}\n", ""
    ))  # fmt: skip
    prefixes = ["front_left_", "front_right_", ""]
    wheels = [f"{prefix}wheel" for prefix in prefixes]
    joints = [f"{wheel}_joint" for wheel in wheels]
    mounts = ["base_link", "base_link", "front_left_wheel"]
    references = [one.get("reference") for one in robot.iter("gazebo")]
    assert references == [
        name for wheel, mount in zip(wheels, mounts, strict=True) for name in (wheel, mount, None)
    ]  # fmt: skip
    assert [one.get("link") for one in robot.iter("contact")] == wheels
    assert [one.get("joint") for one in robot.iter("a")] == joints
    assert [one.get("link1") for one in robot.iter("b")] == wheels
    control = list(robot.iter("ros2_control"))
    assert [one.get("prefix") for one in control] == prefixes
    assert [one.find("joint").get("name") for one in control] == joints
    assert [one.findall("joint/param")[1].text for one in control] == joints
    assert [one.text for one in robot.iter("left_joint")] == joints


def test_what_is_no_reference_stays_as_it_is(tmp_path):
    robot = urdf(tmp_path, WHEEL.replace('  plain: {part: wheel, parent: front_left_wheel, prefix: ""}\n', ""))
    assert {one.get("name") for one in robot.iter("ros2_control")} == {"wheel"}
    assert {(one.get("name"), one.get("type")) for one in robot.iter("sensor")} == {("wheel", "wheel")}
    assert {one.get("other") for one in robot.iter("contact")} == {"wheel"}
    assert {one.text for one in robot.iter("topic")} == {"wheel"}
    assert {one.findall("joint/param")[0].text for one in robot.iter("ros2_control")} == {"wheel"}
    assert {one.get("filename") for one in robot.iter("plugin")} == {"wheel"}


def test_prefix_is_a_name_that_others_may_take(tmp_path):
    text = """robot: r
args: {prefix: {default: theirs_}}
links: {base_link: {}}
parts:
  own: {params: {prefix: {default: own_}}, urdf_elements: ['<a of="${prefix}"/>']}
  named: {let: {prefix: let_}, urdf_elements: ['<a of="${prefix}"/>']}
  around: {urdf_elements: ['<a of="${prefix}"/>']}
use: {x: {part: own}, y: {part: named}, z: {part: around}}
outputs: {urdf: {file: r.urdf}}
"""
    assert [one.get("of") for one in urdf(tmp_path, text).iter("a")] == ["own_", "let_", "theirs_"]
    text = text.replace("args: {prefix: {default: theirs_}}\n", "")
    assert [one.get("of") for one in urdf(tmp_path, text).iter("a")] == ["own_", "let_", "z_"]


def test_loops_and_conditions_stand_beside_value(tmp_path):
    text = """robot: r
links: {base_link: {}}
args: {simulated: {default: false}}
let: {block: <inner x="1"/>}
parts:
  part:
    params: {names: {default: [a, b]}}
    urdf_elements:
      - {if: "${simulated}", value: <no/>}
      - {for: {name: "${names}"}, if: "${name != 'b'}", value: '<yes name="${prefix}${name}">${block}</yes>'}
use: {p: {part: part, with: {names: [a, b, c]}, content: {urdf_elements: [<more/>]}}}
urdf_elements:
  - {if: "${not simulated}", value: <top/>}
outputs: {urdf: {file: r.urdf}}
"""
    robot = urdf(tmp_path, text)
    assert [(one.tag, one.get("name")) for one in robot] == [
        ("link", "base_link"), ("top", None), ("yes", "p_a"), ("yes", "p_c"), ("more", None)
    ]  # fmt: skip
    assert [one.get("x") for one in robot.iter("inner")] == ["1", "1"]


def test_what_is_for_another_program_stays(tmp_path):
    text = """robot: r
links: {base_link: {}}
parts:
  part:
    urdf_elements:
      - <a file="$(find pkg)/x.yaml" cost="$5">$${later} $$ $(arg x)</a>
      - <b file="$(find pkg)/${name}.yaml"/>
use: {p: {part: part}}
outputs: {urdf: {file: r.urdf}}
"""
    robot = urdf(tmp_path, text)
    kept, mixed = robot.find("a"), robot.find("b")
    assert (kept.get("file"), kept.get("cost"), kept.text) == ("$(find pkg)/x.yaml", "$5", "${later} $$ $(arg x)")
    assert mixed.get("file") == "$(find pkg)/p.yaml"


def test_sensors_and_their_types_bring_elements(tmp_path):
    text = """robot: r
links: {base_link: {}}
sensor_types:
  sonar:
    params: {range: {type: length, default: 2 m}}
    urdf_elements: ['<gazebo reference="${frame}"><range of="${name}">${range}</range></gazebo>']
parts:
  corner:
    sensors:
      near: {type: sonar, parent: mount, frame: near_frame}
      other: {type: sonar, parent: mount, frame: other_frame, urdf_elements: [<gazebo reference="other_frame"/>]}
      quiet: {type: sonar, parent: mount, frame: quiet_frame, urdf_elements: []}
use: {left: {part: corner, parent: base_link}}
urdf_elements: [<gazebo reference="base_link"/>]
outputs: {urdf: {file: r.urdf}}
"""
    robot = urdf(tmp_path, text)
    assert [one.get("reference") for one in robot.iter("gazebo")] == [
        "base_link", "left_near_frame", "left_other_frame"
    ]  # fmt: skip
    assert [(one.get("of"), one.text) for one in robot.iter("range")] == [("left_near", "2")]


def test_an_included_robot_in_a_robot_with_parts_keeps_its_own_prefix(tmp_path):
    (tmp_path / "arm.urdf").write_text(
        '<robot name="arm"><link name="wheel"/><gazebo reference="wheel"><a>wheel</a></gazebo></robot>', "utf-8"
    )
    text = WHEEL.replace("robot: cart\n", "robot: cart\ninclude: [{file: arm.urdf, prefix: arm_, parent: base_link}]\n")
    robot = urdf(tmp_path, text.replace('  plain: {part: wheel, parent: front_left_wheel, prefix: ""}\n', ""))
    assert [one.get("reference") for one in robot.iter("gazebo")][:2] == ["arm_wheel", "front_left_wheel"]


VALUES = st.text(
    st.characters(codec="utf-8", exclude_characters="\x00\ufffe\uffff", exclude_categories=["Cs", "Cc"]), max_size=12
)


@given(VALUES)
def test_no_value_breaks_an_element(value):
    """What a reader of XML has is the very value, whatever signs are in it."""
    for before, after in (("<a b='", "'/>"), ('<a x="1" b="', '"/>'), ("<!-- <c d=' --><a b='", "'/>")):
        text = before + fitted(before, value) + after
        assert damage(text) == ""
        assert ET.fromstring(f"<r>{text}</r>")[0].get("b") == value
    text = f"<a>{fitted('<a>', value)}</a>"
    assert damage(text) == ""
    assert ET.fromstring(text).text in (value, value or None) or (len(ET.fromstring(text)) and not damage(value))
    for before, after in (("<a><!--", "--></a>"), ("<a><![CDATA[", "]]></a>")):
        assert damage(before + fitted(before, value) + after) == ""


@pytest.mark.parametrize(
    ("before", "value", "fits"),
    [
        ("<a b='", "tab\tline\n", "tab&#9;line&#10;"),
        ("<a b='x' c=\"", "it's", "it&apos;s"),
        ("<a>", "<b/> and text", "&lt;b/&gt; and text"),
        ("<a>", " <b/> <c>1 &lt; 2</c> ", " <b/> <c>1 &lt; 2</c> "),
        ("<a>", "</a><a>", "&lt;/a&gt;&lt;a&gt;"),
        ("<a><!--", "a--b-", "a- -b- "),
        ("<a><!-- ' -->", "&", "&amp;"),
        ("<a><![CDATA[", "x]]>y & <z", "x]] >y & <z"),
        ("<a><![CDATA[ <b c=' ]]>", '"', '"'),
        ("<", "a&b", "a&b"),
        ("", "<b/>", "<b/>"),
    ],
)
def test_a_value_is_spelt_as_its_place_asks(before, value, fits):
    assert fitted(before, value) == fits


def test_an_element_that_is_no_xml_is_not_renamed():
    text = '<gazebo reference="a"><b></gazebo>'
    assert renamed(text, lambda name: f"x_{name}") == text


def test_all_that_is_renamed_is_a_name_letter_by_letter():
    text = "<gazebo reference = 'a'\n >\t<x>a</x> <parent_link> a </parent_link><!-- a --></gazebo>"
    text += "\n<gazebo reference='&#97;'/>"
    wanted = text.replace("'a'", "'x_a'").replace("> a </p", "> x_a </p")
    assert renamed(text, lambda name: f"x_{name}") == wanted
