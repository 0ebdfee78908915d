"""The URDF of a robot, as text.

It carries the links and joints that robot_state_publisher publishes, for each edge has one publisher; and planar and
floating joints, which robot_state_publisher cannot move: other readers of URDF can. For simulators it carries all of
them (``frames``). Elements that only a URDF has (``urdf_elements``) are where the description has them, unchanged.
Rules of the reader: ``ros/urdfdom@jazzy:urdf_parser``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from markupsafe import Markup

from rosorin_compile.model import Box, Capsule, Cylinder, Inertial, Joint, Mesh, Output, Pose, Robot, Shape, Sphere
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.xml.elements import indented

from ..mesh_files import urdf_file_name
from ..templating import Templates, attribute, attributes, comment
from .content import Content, link_groups, version_of


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the URDF of a robot. Its options are described in ``FORMAT``."""
    content, number, version = Content(robot, output), number_format(output.options), version_of(output)
    shown, steps = content.view, []
    for names, joint in link_groups(shown, shown.joints):
        links = [
            (
                attribute("name", link.name),
                [_inertial(link.inertial, number)] if link.inertial else [],
                [_shape(shape, number) for shape in link.visual],
                [_shape(shape, number) for shape in link.collision],
                _indented(link.urdf_elements, "    "),
            )
            for link in map(shown.link.__getitem__, names)
        ]
        steps.append((links, [] if joint is None else [_joint(joint, number)]))
    stand_ins = {shape.stand_in for _, solid in content.shapes.values() for shape in solid if shape.stand_in}
    values = {"robot": robot, "steps": steps, "stand_ins": sorted(stand_ins), "comment": comment}
    values["names"] = attributes(name=robot.name, **({} if version == "1.0" else {"version": version}))
    values["materials"] = [(attributes(name=m.name), _look(m.rgba, m.texture, number)) for m in shown.materials]
    values["elements"] = _indented(shown.urdf_elements, "  ")
    return templates.own("core/robot.urdf.jinja", values), list(content.diagnostics())


def view(robot: Robot, output: Output) -> Robot:
    """Return the robot that the URDF of an output is meant to contain, in the terms of URDF."""
    return Content(robot, output).view


def added_elements(robot: Robot, output: Output) -> list[str]:
    """Return the elements for Gazebo and ros2_control, which the description has in its own words."""
    return Content(robot, output).blocks


def _indented(texts: Iterable[str], indent: str) -> list[str]:
    return [indented(text, indent) for text in texts]


def _look(rgba: Sequence[float] | None, texture: str, number: NumberFormat) -> str:
    colour = f"<color{attributes(rgba=numbers(rgba, number))}/>" if rgba is not None else ""
    return f"{colour}<texture{attributes(filename=urdf_file_name(texture))}/>" if texture else colour


def _shape(solid: Shape, number: NumberFormat) -> tuple[Any, ...]:
    """Return a shape as attributes: name, origin, geometry, sizes, material; then its look and kept elements."""
    shape, sizes = solid.geometry, dict[str, str]()
    if isinstance(shape, Box):
        sizes = {"size": numbers(shape.size, number)}
    elif isinstance(shape, (Cylinder, Capsule)):
        sizes = {"radius": number(shape.radius), "length": number(shape.length)}
    elif isinstance(shape, Sphere):
        sizes = {"radius": number(shape.radius)}
    elif isinstance(shape, Mesh):
        sizes = {"filename": urdf_file_name(shape.file), "scale": numbers(shape.scale, number)}
    else:
        raise TypeError(f"{type(shape).__name__} is not a solid")
    name, material = (attributes(name=text) if text else "" for text in (solid.name, solid.material))
    look, kept = _look(solid.rgba, solid.texture, number), _indented(solid.urdf_elements, "      ")
    return name, _origin(solid.pose, number), type(shape).__name__.lower(), attributes(**sizes), material, look, kept


def _origin(pose: Pose, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(pose.xyz, number), rpy=vector(pose.rpy, number))


def _inertial(inertial: Inertial, number: NumberFormat) -> tuple[Markup, ...]:
    """Return an inertial as attributes of its elements: origin, mass, moments."""
    texts = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertial.printed(number), strict=True))
    moments = attributes(**{key: texts[key] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")})
    return _origin(inertial.pose, number), attributes(value=number(inertial.mass)), moments


def _joint(joint: Joint, number: NumberFormat) -> tuple[Any, ...]:
    """Return a joint as attributes: names, links, origin; then its elements with theirs; then those it has kept."""
    inner: list[tuple[str, Markup]] = []
    if not joint.is_fixed and not joint.is_axleless:
        inner.append(("axis", attributes(xyz=vector(joint.axis, number))))
    for tag, entry, keys in (
        ("calibration", joint.calibration, ("rising", "falling", "reference_position")),
        ("limit", joint.limit, ("lower", "upper", "effort", "velocity")),
        ("dynamics", joint.dynamics, ("damping", "friction")),
        ("mimic", joint.mimic, ("multiplier", "offset")),
        ("safety_controller", joint.safety, ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")),
    ):
        values = {key: value for key in keys if entry is not None and (value := getattr(entry, key)) is not None}
        leader = {"joint": joint.mimic.joint} if joint.mimic is not None and tag == "mimic" else {}
        if entry is not None:
            inner.append((tag, attributes(**leader, **{key: number(value) for key, value in values.items()})))
    names = attribute("name", joint.name) + attribute("type", joint.type)
    ends = attribute("link", joint.parent), attribute("link", joint.child)
    return (names, *ends, _origin(joint.origin, number), inner, _indented(joint.urdf_elements, "    "))
