"""Static transforms in launch files of people: read from every form, and held against the description."""

import math

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import static_tf
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Limit, Link, Pose, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.ros.launch_files import LaunchError, LaunchNode, check_node, parse_arguments, static_nodes
from rosorin_compile.source.diagnostics import Source
from support.paths import data_text

CASES = yaml.safe_load(data_text("cases/launch_files.yaml"))
LASER = Pose((0.048156, 7.5552e-05, 0.106748), (0.0, 0.0, math.pi))
STATIC = Publisher(STATIC_TRANSFORM_PUBLISHER, "tf_base_laser")
ROBOT = Robot(
    "r",
    tuple(map(Link, ("base_link", "laser", "arm", "claw"))),
    (
        Joint("lidar_joint", "fixed", "base_link", "laser", LASER, publisher=STATIC),
        Joint("arm_joint", "revolute", "base_link", "arm", limit=Limit(-1, 1, 1, 1)),
        Joint("claw_joint", "fixed", "arm", "claw", publisher=Publisher(UNPUBLISHED, about="nobody")),
    ),
    edges=(Edge("map", "base_link", Publisher(NODE, "amcl"), moving=True),),
)
RIGHT = (
    "--x 0.048156 --y 0.0000756 --z 0.106748 --roll 0 --pitch 0 --yaw 3.14159265"
    " --frame-id base_link --child-frame-id laser"
)
WORDS = RIGHT.split()

DIRECT, HELPER = CASES["direct"], CASES["helper"]


def calls(name: str, text: str) -> list[LaunchNode]:
    return static_nodes(Source(name, text))


def words_of(name: str, text: str) -> list[tuple[str | None, ...] | None]:
    """Return the arguments of each static_transform_publisher, None if one of them is unknown."""
    found = [call.arguments for call in calls(name, text)]
    return [None if words is None or None in words else words for words in found]


@pytest.mark.parametrize(
    "arguments",
    [
        repr(WORDS),
        repr(tuple(WORDS)),
        f"{RIGHT!r}.split()",
        f"['--x', '0.048156'] + {WORDS[2:]!r}",
        f"{WORDS[:10]!r} + ['--yaw', str(math.pi)] + {WORDS[12:]!r}",
        f"{WORDS[:13]!r} + [f'base_{{\"link\"}}'] + {WORDS[14:]!r}",
    ],
)
def test_python_with_plain_arguments(arguments: str) -> None:
    found = calls("a.launch.py", DIRECT.replace("ARGUMENTS", arguments))
    assert [call.span.line for call in found] == [6]
    said = parse_arguments(found[0].arguments or ())
    assert said is not None
    assert (said.parent, said.child) == ("base_link", "laser")
    assert said.transform.xyz == (0.048156, 0.0000756, 0.106748)
    assert said.transform.angle_to(LASER.transform()) < 1e-8


def test_python_with_a_helper_tells_the_line_of_each_call() -> None:
    text = HELPER.replace("YAW", "'3.14159265'")
    found = calls("a.launch.py", text)
    assert [call.span.line for call in found] == [13, 14]
    assert found[0].arguments == tuple(WORDS)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.launch.xml", f'<launch>\n<node pkg="tf2_ros" exec="static_transform_publisher" args="{RIGHT}"/></launch>'),
        ("a.launch.xml", f'<launch><arg name="p" default="base_link"/>\n<group><node pkg="tf2_ros" '
         f'exec="static_transform_publisher" args="{RIGHT.replace("base_link", "$(var p)")}"/></group></launch>'),
        ("a.launch.yaml", f"launch:\n- node: {{pkg: tf2_ros, exec: static_transform_publisher, args: '{RIGHT}'}}\n"),
        ("a.launch.yml", "launch:\n- node:\n    pkg: tf2_ros\n    exec: static_transform_publisher\n"
         f'    args: "{RIGHT.replace("laser", "$(var c)")}"\n- arg: {{name: c, default: laser}}\n'),
    ],
)  # fmt: skip
def test_xml_and_yaml(name: str, text: str) -> None:
    found = calls(name, text)
    assert [call.arguments for call in found] == [tuple(WORDS)]
    assert found[0].span.line == 2


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.launch.py", "static_transform_publisher (", "not a Python file"),
        ("a.launch.xml", "<launch static_transform_publisher", "not XML"),
        ("a.launch.xml", '<!DOCTYPE a [<!ENTITY b "c">]><launch>static_transform_publisher</launch>', "not XML"),
        ("a.launch.yaml", "launch: [static_transform_publisher", "not YAML"),
        ("a.launch.py", "static_transform_publisher = " + "(" * 500 + ")" * 500, "not a Python file"),
    ],
)
def test_launch_files_that_cannot_be_read(name: str, text: str, message: str) -> None:
    with pytest.raises(LaunchError, match=message):
        calls(name, text)


@pytest.mark.parametrize("text", ["while True: pass", "import os; os.abort()", "x = 'a' * 10 ** 12"])
def test_nothing_is_run(text: str) -> None:
    assert calls("a.launch.py", f"{text}\n# static_transform_publisher\n") == []


def told(args: str) -> list[str]:
    source = Source("a.launch.xml", f'<launch>\n<node exec="static_transform_publisher" args="{args}"/>\n</launch>')
    return [
        f"{d.severity}[{d.rule}]:{d.span.line if d.span else 0}: {d.message}"
        for call in calls("a.launch.xml", source.text)
        for d in check_node(ROBOT, call)
    ]


@pytest.mark.parametrize(("args", "said"), CASES["what_differs"])
def test_what_differs(args: str, said: list[str]) -> None:
    parent = "base_footprint" if "base_footprint" in args else "base_link"
    begin = f"error[deployed-launch-differs]:2: {parent} -> laser is not as described: "
    assert told(args) == [begin + one for one in said]


@pytest.mark.parametrize(("args", "said"), CASES["other_mistakes"])
def test_other_mistakes(args: str, said: str) -> None:
    assert told(args) == [said]


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_what_we_print_is_as_described(data: st.DataObject) -> None:
    number = st.floats(-10, 10)
    pose = Pose(data.draw(st.tuples(number, number, number)), data.draw(st.tuples(number, number, number)))
    joint = Joint("j", "fixed", "a", "b", pose, publisher=STATIC)
    robot = Robot("r", (Link("a"), Link("b")), (joint,))
    text = DIRECT.replace("ARGUMENTS", repr(list(static_tf.static_transforms(robot)[0][0].arguments)))
    (call,) = calls("a.launch.py", text)
    assert list(check_node(robot, call)) == []


PIECES = st.sampled_from([*HELPER.split("\n"), *CASES["pieces"]])


@settings(max_examples=200, deadline=None)
@given(st.lists(PIECES, max_size=30), st.sampled_from(["a.launch.py", "a.launch.xml", "a.launch.yaml"]))
def test_any_text_is_read_or_refused(pieces: list[str], name: str) -> None:
    text = "static_transform_publisher\n" + "\n".join(pieces)
    try:
        found = calls(name, text)
    except LaunchError:
        return
    for call in found:
        list(check_node(ROBOT, call))


# Static transforms of launch files in Python, as people write them: read where they are plain, and never guessed.


READ = ("--x", "0.1", "--frame-id", "base_link", "--child-frame-id", "laser")


@pytest.mark.parametrize("text", CASES["plain_values_are_read"])
def test_plain_values_are_read(text: str) -> None:
    (call,) = calls("a.launch.py", text)
    assert call.arguments == READ
    assert call.span.line >= 4


@pytest.mark.parametrize("text", CASES["what_is_known_only_at_run_time_is_never_guessed"])
def test_what_is_known_only_at_run_time_is_never_guessed(text: str) -> None:
    assert words_of("a.launch.py", text) == [None]


@pytest.mark.parametrize("call", ["*WORDS", "'n', **WORDS", "'n', *WORDS, x='1'"])
def test_a_call_that_unpacks_is_left_unknown(call: str) -> None:
    """Neither the defaults of the helper nor names of the file stand in for what is unpacked."""
    text = f"""\
x = '0.1'
def static_tf(name, x='0', child='laser'):
    return Node(executable='static_transform_publisher', arguments=['--x', x, '--child-frame-id', child])
static_tf({call})
"""
    (node,) = calls("a.launch.py", text)
    assert node.span.line == 4
    assert None in (node.arguments or (None,))
