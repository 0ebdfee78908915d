"""The URDF of a robot, as text.

It carries the links and joints that robot_state_publisher publishes, for each edge has one publisher; and planar and
floating joints, which robot_state_publisher cannot move: other readers of URDF can. Elements that only a URDF has
(``urdf_elements``) stand where the description has them, letter by letter.
Rules of the reader: ``ros/urdfdom@jazzy:urdf_parser``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from markupsafe import Markup

from ...diagnostics import NOTE, WARNING, Diagnostic
from ...diagnostics.registry import FORMATS, Rule
from ...diagnostics.wording import counted
from ...model import ROWS, Box, Capsule, Cylinder, Joint, Link, Mesh, Output, Pose, Robot, Shape, Sphere
from ...numbers import NUMBER_FORMATS, NumberFormat, vector
from ...xml.elements import indented
from ..templating import BUILTIN, Templates, attributes, comment

RULES = (
    Rule(
        "urdf-cannot-say",
        "A warning: URDF 1.0 has no capsule, cylinders are written. A note: what hangs on links that are not in the "
        "URDF.",
        'A cylinder and spheres say it exactly; `version: "1.2"` has capsules.',
        FORMATS,
    ),
)

ELEMENTS = ["inertial", "visual", "collision", "dynamics", "urdf_elements"]


class _Format(NamedTuple):
    """How the URDF is asked for: how numbers are printed, its elements, its version, the boxes of height maps."""

    number: NumberFormat
    elements: Sequence[str]
    version: str
    boxes: str

    def vector(self, numbers: Iterable[float]) -> str:
        return vector(numbers, self.number)

    def kept(self, texts: Iterable[str], indent: str) -> list[Markup]:
        """Return elements that the description has for the URDF."""
        if "urdf_elements" not in self.elements:
            return []
        return [Markup(indented(text, indent)) for text in texts]  # noqa: S704 - the rules found it well formed


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the URDF of a robot.

    Options: ``number_format`` (exact or six), ``elements`` (of inertial, visual, collision, dynamics and urdf_elements;
    default all), ``version`` (1.0 or 1.2, which has capsules), ``height_maps`` (the form of their boxes), ``gazebo``
    (true, or which Gazebo; default no sensors).
    """
    form = _form(output)
    number, elements = form.number, form.elements
    groups = link_groups(robot, robot.in_urdf())
    carried = frozenset(name for names, _ in groups for name in names)
    capsules: dict[str, int] = {}
    stand_ins: set[str] = set()
    steps = []
    for names, joint in groups:
        rows = []
        for name in names:
            link = robot.link[name]
            visual, collision = (
                robot.shapes_at(name, carried, purpose, form.boxes)[0] if purpose in elements else []
                for purpose in ("visual", "collision")
            )
            capsules[name] = sum(isinstance(solid.geometry, Capsule) for solid in (*visual, *collision))
            stand_ins |= {solid.stand_in for solid in collision if solid.stand_in}
            inertial = _inertial(link, number) if "inertial" in elements else []
            shapes = _rows(robot, name, visual, form), _rows(robot, name, collision, form)
            rows.append((attributes(name=name), inertial, *shapes, form.kept(link.urdf_elements, "    ")))
        steps.append((rows, [] if joint is None else [_joint(joint, form)]))
    diagnostics = [*_without_capsules(capsules, form), *_left_out(robot, carried, elements)]
    values = {"robot": robot, "steps": steps, "stand_ins": sorted(stand_ins), "comment": comment}
    values["names"] = attributes(name=robot.name, **({} if form.version == "1.0" else {"version": form.version}))
    values["materials"] = _materials(robot, form) if "visual" in elements else []
    kept = form.kept(robot.urdf_elements, "  ")
    if output.options.get("gazebo"):
        blocks, told = _gazebo(robot, output, form, carried)
        kept += blocks
        diagnostics += told
    values["elements"] = kept
    return templates.render(f"{BUILTIN}robot.urdf.jinja", values), diagnostics


def _gazebo(
    robot: Robot, output: Output, form: _Format, carried: frozenset[str]
) -> tuple[list[Markup], list[Diagnostic]]:
    """Return what Gazebo has of the sensors, and what it will not see of them."""
    from .gazebo import Carried, distribution, kept_joints, sensors

    def collisions(link: str) -> list[str]:
        shapes = robot.shapes_at(link, carried, "collision", form.boxes)[0] if "collision" in form.elements else []
        return [shape.name for shape in shapes]

    kept = kept_joints(robot.urdf_elements) if "urdf_elements" in form.elements else frozenset()
    there = Carried(carried, robot.in_urdf(), "inertial" in form.elements, collisions, kept)
    return sensors(robot, there, distribution(output.options["gazebo"]), form.number)


def brought(robot: Robot, output: Output) -> list[str]:
    """Return the elements that an output has for Gazebo, and the description in its own words."""
    if not output.options.get("gazebo"):
        return []
    carried = frozenset(name for names, _ in link_groups(robot, robot.in_urdf()) for name in names)
    return [str(block) for block in _gazebo(robot, output, _form(output), carried)[0]]


def _form(output: Output) -> _Format:
    number = NUMBER_FORMATS[output.options.get("number_format", "exact")]
    return _Format(number, output.options.get("elements", ELEMENTS), _version(output), _boxes(output))


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


def _boxes(output: Output) -> str:
    """Return the form of the boxes that height maps are in an output."""
    return str(output.options.get("height_maps", ROWS))


def _version(output: Output) -> str:
    """Return the version of the format that an output asks for; 1.2 is a number in YAML, and a name all the same."""
    return str(output.options.get("version", "1.0"))


def solids(robot: Robot, link: str, output: Output, carried: frozenset[str]) -> list[Shape]:
    """Return the collision shapes that a link has in a URDF that carries these frames."""
    shapes = robot.shapes_at(link, carried, "collision", _boxes(output))[0]
    return shapes if _version(output) != "1.0" else [_cylinder(shape) for shape in shapes]


def _cylinder(shape: Shape) -> Shape:
    """Return a capsule as the cylinder that stands for it, any other shape as it is."""
    geometry = shape.geometry
    if not isinstance(geometry, Capsule):
        return shape
    return Shape(Cylinder(geometry.radius, geometry.length + 2 * geometry.radius), shape.pose)


def _materials(robot: Robot, form: _Format) -> list[tuple[Markup, Markup]]:
    """Return the materials of the robot: the attributes of each, and what is in it."""
    return [(attributes(name=one.name), _look(one.rgba, one.texture, form)) for one in robot.materials]


def _look(rgba: Sequence[float] | None, texture: str, form: _Format) -> Markup:
    """Return the elements of a material."""
    colour = Markup("<color{}/>").format(attributes(rgba=form.vector(rgba))) if rgba is not None else Markup()
    return colour + Markup("<texture{}/>").format(attributes(filename=texture)) if texture else colour


def _rows(robot: Robot, link: str, solids: list[Shape], form: _Format) -> list[tuple[Any, ...]]:
    """Return each solid as attributes of its elements: name, origin, kind and sizes, material; and what is in them."""
    rows = []
    for index, solid in enumerate(solids, 1):
        kind, sizes = _geometry(solid, form)
        look = _look(solid.rgba, solid.texture, form)
        material = solid.material or (_own_material(robot, f"{link}_{index}") if look else "")
        names = attributes(name=solid.name) if solid.name else ""
        surface = attributes(name=material) if material else ""
        kept = form.kept(solid.urdf_elements, "      ")
        rows.append((names, _origin(solid.origin(), form.number), kind, attributes(**sizes), surface, look, kept))
    return rows


def _own_material(robot: Robot, name: str) -> str:
    """Return a name for the material of one visual that no other material has."""
    while name in robot.material:
        name += "_"
    return name


def _origin(pose: Pose, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(pose.xyz, number), rpy=vector(pose.rpy, number))


def _geometry(solid: Shape, form: _Format) -> tuple[str, dict[str, str]]:
    """Return the element and the attributes of a geometry (http://wiki.ros.org/urdf/XML/link)."""
    shape, number = solid.geometry, form.number
    if isinstance(shape, Box):
        return "box", {"size": vector(shape.size, number)}
    if isinstance(shape, Cylinder):
        return "cylinder", {"radius": number(shape.radius), "length": number(shape.length)}
    if isinstance(shape, Capsule) and form.version != "1.0":
        return "capsule", {"radius": number(shape.radius), "length": number(shape.length)}
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


def _joint(joint: Joint, form: _Format) -> tuple[Any, ...]:
    """Return a joint as attributes: names, links, origin; then its elements with theirs; then those it has kept."""
    number, dynamics, mimic = form.number, joint.dynamics, joint.mimic
    inner: list[tuple[str, Markup]] = []
    along = joint.type not in ("fixed", "floating")
    if along:
        inner.append(("axis", attributes(xyz=form.vector(joint.axis))))
    if joint.calibration is not None:
        inner.append(("calibration", _given(joint.calibration, ("rising", "falling", "reference_position"), number)))
    if along and joint.limit is not None:
        inner.append(("limit", _given(joint.limit, ("lower", "upper", "effort", "velocity"), number)))
    if "dynamics" in form.elements and dynamics is not None and (dynamics.damping or dynamics.friction):
        inner.append(("dynamics", _given(dynamics, ("damping", "friction"), number)))
    if mimic is not None:
        factor, offset = number(mimic.multiplier), number(mimic.offset)
        inner.append(("mimic", attributes(joint=mimic.joint, multiplier=factor, offset=offset)))
    if joint.safety is not None:
        keys = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
        inner.append(("safety_controller", _given(joint.safety, keys, number)))
    names = attributes(name=joint.name, type=joint.type)
    ends = attributes(link=joint.parent), attributes(link=joint.child)
    return (names, *ends, _origin(joint.origin, number), inner, form.kept(joint.urdf_elements, "    "))


def _given(entry: object, keys: Iterable[str], number: NumberFormat) -> Markup:
    """Return the numbers of an entry as attributes, those that are given."""
    values = {key: getattr(entry, key) for key in keys}
    return attributes(**{key: number(value) for key, value in values.items() if value is not None})


def _left_out(robot: Robot, carried: frozenset[str], elements: Sequence[str]) -> list[Diagnostic]:
    """Return a note on what hangs on links that the URDF does not carry and cannot be moved to one that it does."""
    lost = []
    for link in robot.walk():
        if link.name in carried:
            continue
        fixed = _reaches_by_fixed_joints(robot, link.name, carried)
        shapes = [p for p in ("visual", "collision") if p in elements and getattr(link, p) and not fixed]
        inertial = ["inertial"] if "inertial" in elements and link.inertial else []
        kept = ["urdf_elements"] if "urdf_elements" in elements and link.urdf_elements else []
        lost += [f"{link.name} ({', '.join(shapes + inertial + kept)})"] if shapes or inertial or kept else []
    ours = robot.in_urdf()
    lost += [f"{j.name} (urdf_elements)" for j in robot.joints if j.urdf_elements and j not in ours]
    if not lost:
        return []
    message = f"not in the URDF, because robot_state_publisher does not publish them: {', '.join(lost)}"
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


def _without_capsules(capsules: dict[str, int], form: _Format) -> list[Diagnostic]:
    """Return the warning about capsules, counted by link: URDF 1.0 has no word for them."""
    links = [link for link, count in capsules.items() if count]
    if form.version != "1.0" or not links:
        return []
    count, others = sum(capsules.values()), len(links) - 1
    where = f"link {links[0]}" + (f" and {counted(others, 'other link')}" if others else "")
    become = "are written as cylinders" if count > 1 else "is written as a cylinder"
    message = f"URDF 1.0 has no capsule: {count} on {where} {become} of the same full length"
    help = 'use a cylinder and spheres, or say version: "1.2" where all readers of the URDF know it'
    return [Diagnostic("urdf-cannot-say", WARNING, message, help=help)]
