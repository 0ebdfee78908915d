"""Compare two models of a robot leaf by leaf, to prove that an import lost nothing.

``diff`` compares what robots are; here every leaf of the model counts.
"""

from __future__ import annotations

from dataclasses import fields, replace

from rosorin_compile.compare.describe import Describer
from rosorin_compile.compare.precision import NOISE, Precision
from rosorin_compile.compare.walk import compare_leaves, leaves
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import lacks
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Ellipsoid, Joint, Link, Robot, Shape
from rosorin_compile.model.joint import ROBOT_STATE_PUBLISHER, Dynamics, Publisher
from rosorin_compile.model.shape import plain

_PUBLISHED = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)


def model_differences(
    one: Robot, other: Robot, tolerance: float = NOISE, *, carried_by_urdf: bool = False
) -> list[str]:
    """Return the differences between two robots, one sentence each.

    Numbers may differ by ``tolerance``, absolute or relative. With ``carried_by_urdf`` only what a URDF says is
    compared.
    """
    if carried_by_urdf:
        one, other = _in_urdf(_without_lacking(one, other)), _in_urdf(other)
    sides = leaves(replace(one, source=other.source)), leaves(other)
    known = _of(tolerance), _of(tolerance)
    describer = Describer(one, sides, known, tolerance)
    return [text for _, text in describer.describe(compare_leaves(*sides, known, tolerance))]


def section_differences(one: Robot, other: Robot, section: str) -> list[str]:
    """Return the differences between one section of two robots, such as ``moveit``."""
    empty = Robot("", (), ())
    first, second = (replace(empty, **{section: getattr(robot, section)}) for robot in (one, other))
    return model_differences(first, second)


def _of(tolerance: float) -> Precision:
    return lambda key, *values: tolerance / 2  # noqa: ARG005


def _without_lacking(one: Robot, other: Robot) -> Robot:
    """Copy the values that a URDF cannot express from ``other`` to ``one``."""
    urdf, known = FORMATS.published(), {field.name for field in fields(one)}
    skipped = [name for name in sections() if name in known and lacks(urdf, name)]
    return replace(one, sections=other.sections, **{name: getattr(other, name) for name in skipped})


def _in_urdf(robot: Robot) -> Robot:
    """Reduce a robot to the values that a URDF can express."""
    links, joints = tuple(map(_link, robot.links)), tuple(map(_joint, robot.joints))
    materials = tuple(replace(material, mjcf={}) for material in robot.materials)
    return replace(robot, links=links, joints=joints, materials=materials, mjcf=())


def _link(link: Link) -> Link:
    shapes = (tuple(_shape(s) for shape in some for s in shape.solids()) for some in (link.collision, link.visual))
    collision, visual = shapes
    return Link(link.name, link.inertial, visual=visual, collision=collision, urdf_elements=link.urdf_elements)


def _shape(shape: Shape) -> Shape:
    geometry = plain(shape.geometry) if isinstance(shape.geometry, Ellipsoid) else shape.geometry
    return replace(shape, geometry=geometry, material="", contact=None, mjcf={})


def _joint(joint: Joint) -> Joint:
    dynamics = joint.dynamics and Dynamics(joint.dynamics.damping, joint.dynamics.friction)
    kind = "floating" if joint.type == "ball" else joint.type
    return replace(joint, type=kind, dynamics=dynamics, actuator=None, mjcf={}, publisher=_PUBLISHED)
