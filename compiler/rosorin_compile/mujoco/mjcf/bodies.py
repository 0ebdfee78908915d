"""Bodies: how an MJCF of ours names and groups what a robot has. Its writer and its readers both ask here."""

from __future__ import annotations

from collections.abc import Sequence

from rosorin_compile.model import Joint, Robot
from rosorin_compile.model.cached import of_robot

# The body that everything else stands in.
WORLD = "world"
# What a pair of ours says beside its shapes, and one of others that says nothing: that they touch.
TOUCHES: tuple[dict[str, str], ...] = ({}, {"condim": "1"})

# The ends of the names of the joints that stand for one, as MuJoCo's own reader of URDF names them.
PLANAR = ("_TX", "_TY", "_RZ")
FLOATING = ("_TX", "_TY", "_TZ", "_R")

# How stiff the coupling of a joint that follows another one is, where nobody says it.
STIFF = {"solref": (0.005, 1.0), "solimp": (0.95, 0.99, 0.001)}
# The ends of the names of default classes (``classes``), and the groups by which viewers show and hide.
VISUAL, COLLISION = "visual", "collision"
# What of wheels collides: with the floor alone (``masks``).
WHEEL = "wheel_collision"
# Collision shapes that are seen, in the groups of visuals: those of links that have nothing else to be seen by.
SHOWN, SHOWN_WHEEL = "shown_collision", "shown_wheel_collision"

# The sites that mark where frames are: dots that a viewer shows when it is asked for group 4.
FRAME = "frame"

VISUAL_GROUP, COLLISION_GROUP, FRAME_GROUP = 2, 3, 4


def body_name(robot: Robot, link: str) -> str:
    """Return the name of the body of a link: its own, but for that of the body that MuJoCo has already."""
    if link == robot.root and robot.root_in_world.world:
        return WORLD
    name = link if link != WORLD else f"{WORLD}_link"
    known = {*robot.link, *(edge.child for edge in robot.edges)} if link == WORLD else ()
    while name in known:
        name += "_"
    return name


def reference(joint: Joint) -> float:
    """Return the position (rad or m) of a joint at which MuJoCo begins, and has its body (``ref``)."""
    value = joint.mjcf.get("ref", 0.0) if joint.moves else 0.0
    return value if isinstance(value, (int, float)) else 0.0


def shifted(coefficients: Sequence[float], by: float) -> list[float]:
    """Return the coefficients of the polynomial of ``x + by`` as one of ``x``, from the lowest up.

    >>> shifted([1, 2, 3], 1)
    [6, 8, 3]
    """
    made = list(coefficients)
    for lowest in range(len(made)):
        for place in range(len(made) - 2, lowest - 1, -1):
            made[place] += by * made[place + 1]
    return made


def is_free(robot: Robot, joint: Joint) -> bool:
    """Say whether a floating joint is one of MuJoCo's: those stand in the world alone."""
    return joint.type == "floating" and robot.root_in_world.world and joint.parent == robot.root


@of_robot
def weld_groups(robot: Robot) -> dict[str, list[str]]:
    """Return the links that no joint moves against each other, in the order of the tree, by the topmost of them."""
    top: dict[str, str] = {}
    groups: dict[str, list[str]] = {}
    above = robot.joint_to
    for link in robot.walk():
        name = link.name
        joint = above.get(name)
        if joint is None or not joint.is_fixed:
            top[name] = name
            groups[name] = [name]
        else:
            top[name] = top[joint.parent]
            groups[top[name]].append(name)
    return groups
