"""Robots whose trees of frames tests draw."""

from hypothesis import strategies as st

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Joint, Limit, Link, Output, Publisher, Robot
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.viewer import frames_picture

SVG = "{http://www.w3.org/2000/svg}"
ODD = ("end", "a b", "x`y`", "[z]{q}", "sub|graph", "#35;", "%%c", "漢字", "\\n", "--", "style", "/ns/f", "**b**", "é")
NOBODY = Publisher(UNPUBLISHED, about="not in /joint_states")


def drawn(robot: Robot, file: str, modes: list[str] | None = None) -> str:
    text, said = frames_picture.write(robot, output(file, modes), Templates())
    assert said == []
    return text


def output(file: str, modes: list[str] | None = None) -> Output:
    return Output("picture", "frames_picture", file, {} if modes is None else {"modes": modes})


# Robots with odd names, several publishers, modes, and frames that nobody publishes.

name = st.text(st.characters(codec="utf-8", exclude_categories=("C", "Z"), exclude_characters="<>&\"'"), min_size=1)
names = st.lists(
    st.one_of(st.sampled_from(ODD), name.map(lambda text: text[:20])), min_size=2, max_size=12, unique=True
)
WHENS = ("", "a", "not a", "a and not b", "b or not a")


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    found = draw(names)
    said = draw(st.sampled_from(("", "because", "a | b\n c", 'say "no" [x] {y} #1;')))
    publishers = [Publisher("robot_state_publisher", "robot_state_publisher"), Publisher(NODE, draw(name))]
    publishers += [Publisher(STATIC_TRANSFORM_PUBLISHER, draw(name)), Publisher(UNPUBLISHED, about=said)]
    joints = []
    for at, child in enumerate(found[1:], 1):
        parent = found[draw(st.integers(0, at - 1))]
        kind = draw(st.sampled_from(("fixed", "revolute")))
        publisher = draw(st.sampled_from(publishers if kind == "fixed" else [*publishers[:2], publishers[3]]))
        joints.append(Joint(f"{child} joint", kind, parent, child, limit=Limit(-1, 1), publisher=publisher))
    fresh = [text for text in draw(names) if text not in found]
    edges = []
    for at, child in enumerate(fresh):
        parent = draw(st.sampled_from([*found, *fresh[:at]]))
        edges.append(Edge(parent, child, draw(st.sampled_from(publishers)), draw(st.booleans())))
    top = next(text for text in ("odom", "odom 2", "odom 3") if text not in (*found, *fresh))
    when = draw(st.sampled_from(WHENS))
    edges.append(Edge(top, found[0], publishers[1], moving=True, when=when))
    if when:
        edges.append(Edge(top, found[0], Publisher(NODE, "another"), moving=True, when=f"not ({when})"))
    # A joint that the description knows and another node's transform above the same frame, as under a filter.
    below = [joint.child for joint in joints if joint.publisher.kind == UNPUBLISHED]
    if below:
        edges.append(Edge("filter frame", below[0], Publisher(NODE, "filter"), moving=True))
    return Robot("the robot", tuple(map(Link, found)), tuple(joints), edges=tuple(edges), modes=("a", "b"))
