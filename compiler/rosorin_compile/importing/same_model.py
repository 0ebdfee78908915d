"""Compare two robots leaf by leaf, and read compiled robots back, to prove that an import lost nothing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path

from rosorin_compile.compare.describe import Describer
from rosorin_compile.compare.precision import NOISE, Precision
from rosorin_compile.compare.walk import compare_leaves, leaves
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import lacks
from rosorin_compile.formats.gazebo_elements import element_differences, followers_of
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.mesh_files import urdf_file_name
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Ellipsoid, Joint, Link, Mesh, Robot, Shape
from rosorin_compile.model.joint import ROBOT_STATE_PUBLISHER, Dynamics, Publisher
from rosorin_compile.model.shape import plain
from rosorin_compile.source.tree import Map

from .words.sensors import without_collisions

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
    materials = tuple(replace(one, mjcf={}, texture=urdf_file_name(one.texture)) for one in robot.materials)
    return replace(robot, links=links, joints=joints, materials=materials, mjcf=())


def _link(link: Link) -> Link:
    shapes = (tuple(_shape(s) for shape in some for s in shape.solids()) for some in (link.collision, link.visual))
    collision, visual = shapes
    return Link(link.name, link.inertial, visual=visual, collision=collision, urdf_elements=link.urdf_elements)


def _shape(shape: Shape) -> Shape:
    geometry = plain(shape.geometry) if isinstance(shape.geometry, Ellipsoid) else shape.geometry
    if isinstance(geometry, Mesh):
        geometry = replace(geometry, file=urdf_file_name(geometry.file))
    return replace(shape, geometry=geometry, texture=urdf_file_name(shape.texture), material="", contact=None, mjcf={})


def _joint(joint: Joint) -> Joint:
    dynamics = joint.dynamics and Dynamics(joint.dynamics.damping, joint.dynamics.friction)
    kind = "floating" if joint.type == "ball" else joint.type
    return replace(joint, type=kind, dynamics=dynamics, actuator=None, mjcf={}, publisher=_PUBLISHED)


def read_back(stage: Path, texts: Mapping[str, str], tree: Map) -> Imported:
    """Return the robot in the text of the published format (by the names of formats), which is written to a folder.

    ``tree`` is that of the source: what the source is accepted to violate, its copy may.
    """
    format = FORMATS.published()
    file = stage / f"compiled{format.endings[0]}"
    file.write_text(texts[format.name], "utf-8")
    back = read_robot(file, ReadOptions(lenient=True, checked=False))
    if back.tree is not None and "accept" in tree:
        back.tree.put("accept", tree["accept"], back.tree.span, back.tree.span)
    return back


def element_changes(source: Robot, made: Robot) -> list[str]:
    """Return how the elements of a URDF of a source differ from those of its description.

    Both have elements for Gazebo for friction and springs; the description has some for sensors and hardware, too.
    """
    format = FORMATS.published()
    output = next((one for one in made.outputs if one.backend == format.name), None)
    before, after = list(source.urdf_elements), list(made.urdf_elements)
    if output is not None and format.brings is not None:
        before += format.brings(replace(source, sensors=(), control=(), controllers=()), output)
        after += format.brings(made, output)
    texts = without_collisions(before), without_collisions(after)
    return element_differences(*texts, followers_of(source, made.asks_for_humble))


def without_words(robot: Robot, source: Robot) -> Robot:
    """Return a robot with the sections of its source instead of those that elements became."""
    return replace(
        robot,
        urdf_elements=source.urdf_elements,
        sensors=source.sensors,
        edges=source.edges,
        publishers=source.publishers,
        modes=source.modes,
        control=source.control,
        drive=source.drive,
    )
