"""URDF: what robot_state_publisher, MoveIt and most other readers take.

It carries the links and joints that robot_state_publisher publishes, and no other: each edge has one publisher.
Rules of the reader: ``ros/urdfdom@jazzy:urdf_parser``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from markupsafe import Markup

from ..diagnostic import NOTE, WARNING, Diagnostic
from ..formatting import NUMBER_FORMATS, NumberFormat, vector
from ..model import (
    ROBOT_STATE_PUBLISHER,
    Box,
    Capsule,
    Cylinder,
    Joint,
    Link,
    Mesh,
    Output,
    Pose,
    Robot,
    Shape,
    Sphere,
    Transform,
)
from ..templating import BUILTIN, Templates, attributes, comment
from .urdf_reader import read

__all__ = ["emit", "read"]

ELEMENTS = ["inertial", "visual", "collision", "dynamics"]


def emit(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the URDF of a robot.

    Options: ``number_format`` (exact or six), ``elements`` (of inertial, visual, collision and dynamics; default all).
    """
    number = NUMBER_FORMATS[output.options.get("number_format", "exact")]
    elements = output.options.get("elements", ELEMENTS)
    groups = link_groups(robot, robot.published_by(ROBOT_STATE_PUBLISHER))
    carried = frozenset(name for names, _ in groups for name in names)
    diagnostics: list[Diagnostic] = []
    stand_ins: set[str] = set()
    steps = []
    for names, joint in groups:
        rows = []
        for name in names:
            link = robot.link[name]
            visual = moved_here(robot, name, carried, "visual") if "visual" in elements else []
            collision = collisions(robot, name, carried) if "collision" in elements else []
            diagnostics += _unsaid(name, [*visual, *collision])
            stand_ins |= {solid.stand_in for solid in collision if solid.stand_in}
            inertial = _inertial(link, number) if "inertial" in elements else []
            rows.append((attributes(name=name), inertial, _rows(name, visual, number), _rows(name, collision, number)))
        steps.append((rows, [] if joint is None else [_joint(joint, number, "dynamics" in elements)]))
    diagnostics += _left_out(robot, carried, elements)
    values = {"robot": robot, "steps": steps, "stand_ins": sorted(stand_ins), "comment": comment}
    return templates.render(f"{BUILTIN}robot.urdf.jinja", values), diagnostics


def link_groups(robot: Robot, joints: tuple[Joint, ...]) -> list[tuple[list[str], Joint | None]]:
    """Return each joint with the links that it is the first to name; a robot without joints has its root link."""
    if not joints:
        return [([robot.root], None)]
    seen: set[str] = set()
    groups: list[tuple[list[str], Joint | None]] = []
    for joint in joints:
        new = [name for name in (joint.parent, joint.child) if name not in seen]
        seen.update(new)
        groups.append((new, joint))
    return groups


def collisions(robot: Robot, link: str, carried: frozenset[str]) -> list[Shape]:
    """Return the solids that a link of the URDF collides with, those of frames fixed to it first."""
    return moved_here(robot, link, carried, "collision")


def moved_here(robot: Robot, link: str, carried: frozenset[str], purpose: str) -> list[Shape]:
    """Return the solids of a link; ``purpose`` is visual or collision.

    The shapes of frames that are fixed to the link, but not carried themselves, move to the link by the transform
    between the two and come first: those mounted on it, then those of the frames that it is mounted on.
    """
    moved: list[Shape] = []
    waiting = [(link, Transform(), link)]
    while waiting:
        name, transform, came_from = waiting.pop()
        if name != link:
            moved += [solid.moved(transform) for solid in _solids(getattr(robot.link[name], purpose))]
        neighbours = [(n, transform.then(t), name) for n, t in robot.fixed_neighbours(name)]
        waiting += [step for step in reversed(neighbours) if step[0] not in carried and step[0] != came_from]
    return moved + _solids(getattr(robot.link[link], purpose))


def _solids(shapes: Sequence[Shape]) -> list[Shape]:
    return [solid for shape in shapes for solid in shape.solids()]


def _rows(link: str, solids: list[Shape], number: NumberFormat) -> list[tuple[Any, ...]]:
    """Return each solid as the attributes of its elements: origin, kind and sizes, material and colour."""
    rows = []
    for index, solid in enumerate(solids, 1):
        kind, sizes = _geometry(solid, number)
        colour = attributes(rgba=vector(solid.rgba, number)) if solid.rgba else ""
        material = solid.material or (f"{link}_{index}" if colour else "")
        named = attributes(name=material) if material else ""
        rows.append((_origin(solid.origin(), number), kind, attributes(**sizes), named, colour))
    return rows


def _origin(pose: Pose, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(pose.xyz, number), rpy=vector(pose.rpy, number))


def _geometry(solid: Shape, number: NumberFormat) -> tuple[str, dict[str, str]]:
    """Return the element and the attributes of a geometry (http://wiki.ros.org/urdf/XML/link)."""
    shape = solid.geometry
    if isinstance(shape, Box):
        return "box", {"size": vector(shape.size, number)}
    if isinstance(shape, Cylinder):
        return "cylinder", {"radius": number(shape.radius), "length": number(shape.length)}
    if isinstance(shape, Capsule):
        return "cylinder", {"radius": number(shape.radius), "length": number(shape.length + 2 * shape.radius)}
    if isinstance(shape, Sphere):
        return "sphere", {"radius": number(shape.radius)}
    if isinstance(shape, Mesh):
        return "mesh", {"filename": shape.file, "scale": vector(shape.scale, number)}
    raise TypeError(f"{type(shape).__name__} is not a solid")


def _inertial(link: Link, number: NumberFormat) -> list[tuple[Markup, ...]]:
    """Return the attributes of a link's inertial, as a list of one; an empty list for a mere frame."""
    inertial = link.inertial
    if inertial is None:
        return []
    moments = {key: number(getattr(inertial, key)) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")}
    return [(_origin(inertial.pose, number), attributes(value=number(inertial.mass)), attributes(**moments))]


def _joint(joint: Joint, number: NumberFormat, with_dynamics: bool) -> tuple[Markup | str, ...]:
    """Return a joint as the attributes of its elements: names, links, origin, axis, limit, dynamics and mimic."""
    dynamics, mimic = joint.dynamics, joint.mimic
    limit: Markup | str = ""
    damped: Markup | str = ""
    follows: Markup | str = ""
    if joint.moves and joint.limit is not None:
        given = {key: getattr(joint.limit, key) for key in ("lower", "upper", "effort", "velocity")}
        limit = attributes(**{key: number(value) for key, value in given.items() if value is not None})
    if with_dynamics and dynamics is not None and (dynamics.damping or dynamics.friction):
        damped = attributes(damping=number(dynamics.damping), friction=number(dynamics.friction))
    if mimic is not None:
        factor, offset = number(mimic.multiplier), number(mimic.offset)
        follows = attributes(joint=mimic.joint, multiplier=factor, offset=offset)
    names = attributes(name=joint.name, type=joint.type)
    ends = attributes(link=joint.parent), attributes(link=joint.child)
    axis = attributes(xyz=vector(joint.axis, number)) if joint.moves else ""
    return (names, *ends, _origin(joint.origin, number), axis, limit, damped, follows)


def _left_out(robot: Robot, carried: frozenset[str], elements: list[str]) -> list[Diagnostic]:
    """Return a note on what hangs on links that the URDF does not carry and cannot be moved to one that it does."""
    lost = []
    for link in robot.walk():
        if link.name in carried:
            continue
        fixed = _reaches_by_fixed_joints(robot, link.name, carried)
        shapes = [p for p in ("visual", "collision") if p in elements and getattr(link, p) and not fixed]
        inertial = ["inertial"] if "inertial" in elements and link.inertial else []
        lost += [f"{link.name} ({', '.join(shapes + inertial)})"] if shapes or inertial else []
    if not lost:
        return []
    message = f"not in the URDF, because robot_state_publisher does not publish their links: {', '.join(lost)}"
    return [Diagnostic("urdf-cannot-say", NOTE, message)]


def _reaches_by_fixed_joints(robot: Robot, link: str, carried: frozenset[str]) -> bool:
    seen, waiting = {link}, [link]
    while waiting:
        for name, _ in robot.fixed_neighbours(waiting.pop()):
            if name in carried:
                return True
            if name not in seen:
                seen.add(name)
                waiting.append(name)
    return False


def _unsaid(link: str, solids: list[Shape]) -> list[Diagnostic]:
    """Return a warning for the shapes that URDF 1.0 has no word for."""
    capsules = sum(isinstance(solid.geometry, Capsule) for solid in solids)
    if not capsules:
        return []
    message = f"URDF has no capsule: {capsules} on link {link} are written as cylinders of the same full length"
    return [Diagnostic("urdf-cannot-say", WARNING, message, help="use a cylinder and spheres to say it exactly")]
