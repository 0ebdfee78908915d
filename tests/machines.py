"""Small robots for tests of backends."""

from __future__ import annotations

from dataclasses import replace

from rosorin_compile.emit import urdf
from rosorin_compile.model import (
    NODE,
    Actuator,
    Box,
    Capsule,
    Cylinder,
    Dynamics,
    Edge,
    HeightMap,
    Inertial,
    Joint,
    JointPose,
    Limit,
    Link,
    Mimic,
    Output,
    Pose,
    Publisher,
    Robot,
    Shape,
    Sphere,
)
from rosorin_compile.templating import Templates

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
            actuator=Actuator(300.0, 20.0),
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
            actuator=Actuator(20.0, 1.0),
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
            actuator=Actuator(0.3, 0.1),
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
