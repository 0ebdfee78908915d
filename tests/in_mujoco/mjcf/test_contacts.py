"""Who may touch whom: neighbours and what touches at rest do not, and nothing else is hidden, whatever the base."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.formats.templating import Templates  # noqa: E402
from rosorin_compile.model import Cylinder, HeightMap, Joint, Limit, Link, Mesh, Output, Pose, Robot, Shape, Sphere  # noqa: E402
from rosorin_compile.model.robot import JointPose  # noqa: E402
from rosorin_compile.model.simulation import Contact  # noqa: E402
from rosorin_compile.mujoco.mjcf.compare_models import may_touch  # noqa: E402
from rosorin_compile.mujoco.mjcf.contacts import CANNOT, contacts, refused_by_mjx  # noqa: E402  # noqa: E402
from rosorin_compile.mujoco.mjcf.write import write  # noqa: E402
from support.machines import BODY, robot_of  # noqa: E402
from support.simulator import BASES, emit, load, pose, random_states  # noqa: E402
from support.simulator import contacts as touching  # noqa: E402

BALL = (Shape(Sphere(0.1)),)
LIMIT = Limit(-3, 3, 1, 1)


def wrist(*, camera: float = 0.3, tool: float = 0.45, kind: str = "revolute", **changes: object) -> Robot:
    """Return an arm that turns about z; a camera at x on the base and a tool at y on the arm meet after 90 degrees."""
    links = (
        Link("base", BODY, collision=BALL),
        Link("camera", BODY, collision=BALL),
        Link("arm", BODY, collision=BALL),
        Link("tool", BODY, collision=BALL),
    )
    joints = (
        Joint("mount", "fixed", "base", "camera", Pose((camera, 0, 0.15))),
        Joint("turn", kind, "base", "arm", Pose((0, 0, 0.15)), (0.0, 0.0, 1.0), LIMIT),
        Joint("weld", "fixed", "arm", "tool", Pose((0, tool, 0))),
    )
    return replace(Robot("wrist", links, joints), **changes)


def names(robot: Robot) -> list[tuple[str, str]]:
    return list(dict.fromkeys((one.link, other.link) for one, other in contacts(robot).pairs))


def hits(robot: Robot, base: str, angle: float) -> set[tuple[str, str]]:
    model, data = load(emit(robot, base))
    pose(robot, model, data, {"turn": angle})
    return touching(model, data)


@pytest.mark.parametrize("base", BASES)
def test_what_is_fixed_to_neighbours_can_touch_whatever_the_base(base: str) -> None:
    robot = wrist(tool=0.3)
    assert contacts(robot).excluded == [("base", "arm")]
    assert names(robot) == [("camera", "tool")]
    assert hits(robot, base, 0.0) == set()
    assert hits(robot, base, -math.pi / 2) == {("camera", "tool")}


@pytest.mark.parametrize("base", BASES)
def test_what_always_touches_is_excluded_and_what_is_ever_free_is_not(base: str) -> None:
    always = wrist(camera=0.0)
    assert contacts(always).excluded == [("base", "arm"), ("camera", "arm")]
    posed = wrist(tool=0.3, poses=(JointPose("stow", {"turn": -math.pi / 2}),))
    assert contacts(posed).excluded == [("base", "arm")]
    assert hits(posed, base, -math.pi / 2) == {("camera", "tool")}


def test_what_touches_at_zero_alone_is_not_hidden() -> None:
    closed = wrist(kind="prismatic", camera=0.0, tool=0.15)  # a drawer that slides up, out of what is below it
    slide = replace(closed.joints[1], limit=Limit(0, 0.5, 1, 1))
    closed = replace(closed, joints=(closed.joints[0], slide, closed.joints[2]))
    assert contacts(closed).excluded == [("base", "arm")]
    stuck = replace(closed, joints=(closed.joints[0], replace(slide, limit=Limit(0, 0.05, 1, 1)), closed.joints[2]))
    assert ("camera", "arm") in contacts(stuck).excluded


def test_faces_on_each_other_touch_and_a_gap_does_not() -> None:
    touches, apart = wrist(camera=0.2), wrist(camera=0.2001)
    assert ("camera", "arm") in contacts(touches).excluded
    assert ("camera", "arm") not in contacts(apart).excluded


def test_shapes_that_no_motion_brings_together_are_no_pairs() -> None:
    assert names(wrist(tool=0.9)) == []
    assert names(wrist(kind="prismatic", camera=0.6, tool=0.3)) == []
    assert names(wrist(kind="prismatic", camera=0.6, tool=0.15)) == [("base", "tool")]
    assert names(wrist(kind="planar", camera=0.9)) == [("base", "tool"), ("camera", "arm"), ("camera", "tool")]
    assert len(names(wrist(kind="floating", camera=0.9, tool=0.9))) == 3


def test_what_a_mesh_touches_is_not_known_so_it_is_excluded() -> None:
    robot = wrist()
    links = [replace(link, collision=(Shape(Mesh("a.stl")),)) if link.name == "tool" else link for link in robot.links]
    made = contacts(replace(robot, links=tuple(links)))
    assert made.excluded == [("base", "arm"), ("base", "tool"), ("camera", "tool")]
    assert [(one.link, other.link) for one, other in made.pairs] == []


def test_disabled_contacts_come_last_and_have_no_pairs() -> None:
    robot = replace(wrist(tool=0.3), disabled_contacts=(("tool", "camera"), ("arm", "base")))
    assert contacts(robot).excluded == [("base", "arm"), ("tool", "camera")]
    assert contacts(robot).pairs == []


def test_pairs_are_named_as_their_geoms() -> None:
    named = (Shape(Sphere(0.1), name="lens"),)
    robot = wrist(tool=0.3)
    robot = replace(robot, links=tuple(replace(k, collision=named) if k.name == "camera" else k for k in robot.links))
    assert '<pair geom1="lens" geom2="tool_collision_1" condim="1"/>' in emit(robot)


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("seed", range(25))
def test_nothing_new_touches_at_zero_and_nothing_is_hidden_that_neither_rule_hides(seed: int, base: str) -> None:
    """Against a model without pairs and excludes whose filter is off: MuJoCo has every contact there is."""
    chance = random.Random(seed)  # noqa: S311
    robot = robot_of(chance)
    robot = replace(robot, links=tuple(replace(link, inertial=BODY, visual=()) for link in robot.links))
    made = contacts(robot)
    text = emit(robot, base)
    start, end = text.find("<contact>"), text.find("</contact>")
    bare = text if start < 0 else text[:start] + text[end + len("</contact>") :]
    bare = bare.replace("<option ", '<option><flag filterparent="disable"/></option><option ', 1)
    model, data = load(text)
    every, every_data = load(bare)
    hidden = set(map(frozenset, made.excluded))
    for state in [{}, *random_states(robot, 20)]:
        pose(robot, model, data, state)
        pose(robot, every, every_data, state)
        all_of_them, ours = touching(every, every_data), touching(model, data)
        assert ours == {pair for pair in all_of_them if frozenset(pair) not in hidden}


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("seed", range(25))
def test_what_mjx_is_told_not_to_collide_is_what_mujoco_would_look_at(seed: int, base: str) -> None:
    chance = random.Random(seed)  # noqa: S311
    robot = robot_of(chance)
    links = tuple(replace(link, inertial=BODY, collision=_layered(link, chance)) for link in robot.links)
    robot = replace(robot, links=links)
    output = Output("mjcf", "mjcf", "robot.xml", {"base": base})
    model, _ = load(emit(robot, base))
    geoms = [at for at in range(model.ngeom) if model.geom_contype[at] or model.geom_conaffinity[at]]
    kinds = [KINDS[model.geom_type[at]] for at in geoms]
    meeting = {frozenset((kinds[one], kinds[other])) for one, other in np.argwhere(may_touch(model, geoms))}
    assert {frozenset(kinds) for kinds, *_ in refused_by_mjx(robot, output)} == meeting & CANNOT


KINDS = ("plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")


def _layered(link: Link, chance: random.Random) -> tuple[Shape, ...]:
    bits = [{word: chance.choice([None, 1.0, 2.0, 3.0]) for word in ("contype", "conaffinity")} for _ in "123456"]
    contacts = [Contact(values) if chance.random() < 0.5 else None for values in bits]
    return tuple(replace(shape, contact=chance.choice(contacts)) for shape in link.collision)


@pytest.mark.slow
def test_a_height_field_is_never_smaller_than_the_boxes() -> None:
    chance = random.Random(7)  # noqa: S311
    rows = tuple(tuple(chance.choice((0.0, 0.1, 0.15, 0.3)) for _ in range(5)) for _ in range(4))
    grid = Shape(HeightMap((-0.2, -0.3), 0.1, rows, 0.05, "", 0.05), Pose((0.1, 0.0, 0.2), (0.4, 0.2, 1.0)))
    links = (Link("base", BODY, collision=(grid,)), Link("ball", BODY, collision=(Shape(Cylinder(0.02, 0.05)),)))
    robot = Robot("field", links, (Joint("float", "floating", "base", "ball"),))
    texts = [
        write(robot, Output("mjcf", "mjcf", "r.xml", {"height_maps": form}), Templates())[0]
        for form in ("merged", "hfield")
    ]
    assert 'type="hfield"' in texts[1]
    models = [load(text.replace('<exclude body1="base" body2="ball"/>', "")) for text in texts]
    lower, upper = np.array([-0.5, -0.5, -0.2]), np.array([0.6, 0.5, 0.8])
    found = []
    for _ in range(2000):
        at = [chance.uniform(a, b) for a, b in zip(lower, upper, strict=True)]
        both = []
        for model, data in models:
            data.qpos[-7:-4] = at
            mujoco.mj_forward(model, data)
            both.append(bool(touching(model, data)))
        found.append(both)
    assert sum(boxes for boxes, _ in found) > 30
    assert not [at for at, (boxes, field) in enumerate(found) if boxes and not field]
    assert sum(field and not boxes for boxes, field in found) < sum(boxes for boxes, _ in found)
