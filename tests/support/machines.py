"""Small robots for tests of backends."""

import math
import random
from collections.abc import Collection
from dataclasses import replace

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Edge,
    HeightMap,
    Inertial,
    Joint,
    Limit,
    Link,
    Mesh,
    Output,
    Pose,
    Publisher,
    Robot,
    Shape,
    Sphere,
    Vector,
)
from rosorin_compile.model.geometry import norm
from rosorin_compile.model.joint import NODE, Dynamics, Mimic
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.simulation import Actuator

BODY = Inertial(0.7, Pose((0.01, -0.02, 0.03)), 2e-3, 3e-3, 4e-3, 1e-4, -2e-4, 3e-4)
TURNED = replace(BODY, mass=0.2, pose=Pose((0.02, 0.0, -0.01), (0.3, -0.7, 1.1)))
SMALL = Inertial(0.02, Pose((0.0, 0.001, 0.002)), 2e-7, 1.5e-7, 1e-7, 1e-9)
CAMERA_DRIVER = Publisher(NODE, "camera_driver")


def machine() -> Robot:
    """A robot with every shape and every type of joint, a mimic of a mimic, and frames of other nodes."""
    heights = HeightMap((-0.1, -0.1), 0.05, ((0.02, 0.02, 0.0), (0.03, 0.011, 0.011)), 0.01)
    chest = Shape(Box((-0.1, -0.05, 0.0), (0.1, 0.15, 0.2)), Pose((0, 0, 0.5), (0, 0, 0.4)))
    mat = Shape(heights, Pose((0.6, 0.0, -0.3)), stand_in="not measured -- or --- hardly --")
    arm = Shape(Capsule(0.03123456789, 0.21234567891), Pose((0.0, 0.4, 0.1), (0.5, 0.2, 0.0)))
    tyre = Shape(Cylinder(0.05234567891, 0.04345678912), Pose((0.0, 0.9, 0.0), (1.5707963267948966, 0, 0)))
    links = (
        Link("base"),
        Link("torso", BODY, collision=(chest,)),
        Link("mat", collision=(mat,)),
        Link("upper", TURNED, collision=(arm,)),
        Link("wheel", SMALL, collision=(tyre,)),
        Link("slider", BODY, collision=(Shape(Sphere(0.02), Pose((0.9, 0.9, 0.9))),)),
        Link("follower", SMALL),
        Link("second", SMALL),
        Link("laser"),
    )
    turn, slide = Limit(-1.2, 2.0, 3.0, 1.0), Limit(-0.1, 0.3, 5.0, 0.5)
    dynamics = Dynamics(0.1, 0.02, 0.005)
    joints = (
        Joint("stand", "fixed", "base", "torso", Pose((0.1, 0.0, 0.3), (0.1, 0.2, 0.3))),
        Joint("lay", "fixed", "base", "mat", Pose((0.0, 0.1, 0.0))),
        Joint(
            "lift",
            "prismatic",
            "torso",
            "slider",
            Pose((0, 0.1, 0), (0.0, 0.4, 0.0)),
            (0.0, 0.6, 0.8),
            slide,
            dynamics=dynamics,
            actuator=Actuator(kp=300.0, kv=20.0),
        ),
        Joint(
            "shoulder",
            "revolute",
            "slider",
            "upper",
            Pose((0.2, 0.1, 0.05), (-0.4, 1.5, 2.5)),
            (-0.01, 0.02, -0.999),
            turn,
            dynamics=dynamics,
            actuator=Actuator(kp=20.0, kv=1.0),
        ),
        Joint(
            "roll",
            "continuous",
            "upper",
            "wheel",
            Pose((0.0, 0.0, 0.3)),
            (0.0, 1.0, 0.0),
            Limit(-1.0, 1.0, 2.0, 10.0),  # the ends mean nothing to a joint that turns for ever
            dynamics=dynamics,
            actuator=Actuator(kp=0.3, kv=0.1),
        ),
        Joint(
            "claw",
            "revolute",
            "upper",
            "follower",
            Pose((0.0, 0.1, 0.1)),
            (1.0, 0.0, 0.0),
            Limit(-4, 4, 1, 1),
            Mimic("shoulder", -2.0, 0.25),
            Dynamics(0.001, 0.0, 1e-4),
        ),
        Joint(
            "tip",
            "revolute",
            "follower",
            "second",
            Pose((0.0, 0.0, 0.05)),
            (0.0, 0.0, 1.0),
            Limit(-5, 5, 1, 1),
            Mimic("claw", 0.5, -0.1),
            Dynamics(0.001, 0.0, 1e-4),
        ),
        Joint("mount", "fixed", "wheel", "laser", Pose((0.01, 0.02, 0.03), (0.0, 0.0, 3.141592653589793))),
    )
    optical = Pose((0, 0, 0.01), (-1.5707963267948966, 0, -1.5707963267948966))
    edges = (
        Edge("laser", "laser_optical", CAMERA_DRIVER, False, pose=optical),
        Edge("torso", "laser_optical", CAMERA_DRIVER, False, "other", Pose()),
        Edge("laser_optical", "rgb", CAMERA_DRIVER, False),
        Edge("odom", "base", CAMERA_DRIVER, True),
        Edge("torso", "drone", CAMERA_DRIVER, True, pose=Pose()),
    )
    poses = (JointPose("home", {}), JointPose("up", {"shoulder": 0.5, "lift": 0.1, "roll": 7.0}))
    return Robot("machine", links, joints, edges=edges, poses=poses)


def exact_urdf(robot: Robot) -> str:
    return urdf.write(robot, Output("urdf", "urdf", "machine.urdf"), Templates())[0]


def overlapping(**changes) -> Robot:
    """Four boxes in a row that overlap where they are jointed; the first also carries a lid, fixed to it."""
    box = (Shape(Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1))),)
    links = tuple(Link(name, BODY, collision=box) for name in ("a", "lid", "b", "c", "far"))
    joints = (
        Joint("j0", "fixed", "a", "lid"),
        Joint("j1", "revolute", "lid", "b", Pose((0.15, 0, 0)), limit=Limit(-1, 1, 1, 1)),
        Joint("j2", "revolute", "b", "c", Pose((0.02, 0, 0)), limit=Limit(-1, 1, 1, 1)),
        Joint("j3", "revolute", "c", "far", Pose((0.15, 0, 0)), limit=Limit(-1, 1, 1, 1)),
    )
    return replace(Robot("row", links, joints), **changes)


def chain(
    *,
    child: Inertial | None,
    fixed_to_child: Inertial | None = None,
    root: Inertial | None = BODY,
    tip: Inertial | None = BODY,
) -> Robot:
    links = (Link("root", root), Link("child", child), Link("tool", fixed_to_child), Link("tip", tip))
    joints = (
        Joint("turn", "continuous", "root", "child"),
        Joint("weld", "fixed", "child", "tool"),
        Joint("bend", "continuous", "tool", "tip"),
    )
    return Robot("chain", links, joints)


def robot_of(chance: random.Random) -> Robot:
    """Return a robot of up to a dozen links: every type of joint, shapes, masses, mimics."""
    count = chance.randint(2, 12)
    names = [f"link_{index}" for index in range(count)]
    links = [_link(chance, name) for name in names]
    joints: list[Joint] = []
    for index in range(1, count):
        kind = chance.choice(["fixed", "fixed", "revolute", "continuous", "prismatic"])
        joint = Joint(f"joint_{index}", kind, names[chance.randrange(index)], names[index], _pose(chance))
        if kind != "fixed":
            leaders = [other.name for other in joints if other.moves and other.mimic is None]
            mimic = Mimic(chance.choice(leaders), 0.7, 0.1) if leaders and chance.random() < 0.2 else None
            joint = replace(joint, axis=_axis(chance), limit=_limit(chance, kind), mimic=mimic)
        joints.append(joint)
    return Robot("any", tuple(links), tuple(joints))


def as_in_sdf(robot: Robot, weightless: Collection[str] = ()) -> Robot:
    """Return a robot as an SDF can say it: joints called by their links, the least mass none, colours without names."""
    links = tuple(replace(link, inertial=None) if link.name in weightless else link for link in robot.links)
    links = tuple(replace(link, visual=tuple(_coloured(robot, shape) for shape in link.visual)) for link in links)
    joints = tuple(replace(j, name=f"{j.child}_joint") if j.is_fixed else j for j in robot.joints)
    return replace(robot, links=links, joints=joints, materials=())


def _coloured(robot: Robot, shape: Shape) -> Shape:
    material = robot.material.get(shape.material or "")
    return shape if material is None else replace(shape, rgba=material.rgba, material="")


def _vector(chance: random.Random, size: float) -> Vector:
    x, y, z = (round(chance.uniform(-size, size), 4) for _ in range(3))
    return (x, y, z)


def _axis(chance: random.Random) -> Vector:
    vector = _vector(chance, 1.0)
    length = norm(vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length) if length > 0.1 else (0.0, 0.0, 1.0)


def _pose(chance: random.Random) -> Pose:
    return Pose(_vector(chance, 0.5), _vector(chance, 3.0))


def _limit(chance: random.Random, kind: str) -> Limit:
    if kind == "continuous":
        return Limit(effort=2.0, velocity=3.0)
    return Limit(-round(chance.uniform(0.1, 1.0), 3), round(chance.uniform(0.1, 1.0), 3), 2.0, 3.0)


def _link(chance: random.Random, name: str) -> Link:
    inertial = None
    if chance.random() < 0.6:
        inertial = Inertial(round(chance.uniform(0.1, 3), 3), _pose(chance), 0.02, 0.03, 0.035, 0.001, 0.002, 0.003)
    shapes = tuple(_shape(chance) for _ in range(chance.randint(0, 3)))
    return Link(name, inertial, shapes, tuple(_shape(chance) for _ in range(chance.randint(0, 3))))


def _shape(chance: random.Random) -> Shape:
    a, b, c = (round(chance.uniform(0.02, 0.3), 4) for _ in range(3))
    return Shape(chance.choice([Box((-a, -b, -c), (a, b, c)), Cylinder(a, b), Capsule(a, b), Sphere(a)]), _pose(chance))


BOX = Box((-0.1, -0.2, 0.0), (0.1, 0.2, 0.5))
TILT = Pose((0.3, -2 / 7, 1 / 9), (0.4, -1.1, math.e))
LIMIT = Limit(-2.0, 2.5, 3.0, 4.0)
TESTER = Robot(
    "tester",
    (
        Link("base_link", collision=(Shape(BOX),)),
        Link(
            "arm",
            Inertial(1.5, Pose((0.1, 0.0, 0.2), (0.1, 0.2, 0.3)), 0.02, 0.03, 0.04, 0.001, -0.002, 0.003),
            visual=(
                Shape(Cylinder(0.1, 0.4), rgba=(1.0, 0.0, 0.25, 1.0)),
                Shape(Mesh("package://robot/a&b.stl", (0.001, 0.001, 0.002)), TILT, "", (1, 1, 1, 1), "steel"),
            ),
            collision=(Shape(Sphere(0.3), TILT), Shape(BOX, TILT), Shape(Cylinder(0.1, 0.4))),
        ),
        Link("slide"),
        Link("wheel"),
        Link("follower"),
        Link("tool"),
    ),
    (
        Joint("shoulder", "revolute", "base_link", "arm", TILT, (0.6, 0.0, -0.8), LIMIT, None, Dynamics(0.1, 0.2)),
        Joint("slider", "prismatic", "arm", "slide", TILT, (0.0, 0.6, 0.8), Limit(-0.5, 0.5, 1.0, 1.0)),
        Joint("hub", "continuous", "slide", "wheel", TILT, (0.0, 1.0, 0.0), Limit(effort=2.0, velocity=3.0)),
        Joint("finger", "revolute", "arm", "follower", TILT, (0.0, 0.0, 1.0), LIMIT, Mimic("shoulder", -0.5, 0.1)),
        Joint("tool_joint", "fixed", "follower", "tool", TILT),
    ),
)
