"""The URDF of a robot, as text.

It carries the links and joints that robot_state_publisher publishes, for each edge has one publisher; and planar and
floating joints, which robot_state_publisher cannot move: other readers of URDF can. For simulators it carries all of
them (``frames``). Elements that only a URDF has (``urdf_elements``) stand where the description has them, letter
by letter.
Rules of the reader: ``ros/urdfdom@jazzy:urdf_parser``.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rosorin_compile.formats.carriers import shapes_at
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Inertial,
    Joint,
    Link,
    Mesh,
    Output,
    Pose,
    Robot,
    Shape,
    Sphere,
    Vector,
)
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.sections import sections_in_urdf
from rosorin_compile.model.shape import Material, plain
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.wording import counted, first_of, plural
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.escaping import Markup

from ..mesh_files import urdf_file_name
from ..templating import Templates, attribute, attributes, comment
from .masses import BODIES, INERTIAL, frames_of, inertials, joints_of, links_of, standing_still, too_much
from .solids import boxes_of, collisions, version_of

if TYPE_CHECKING:
    T = TypeVar("T")

RULES = (
    Rule(
        "urdf-cannot-say",
        "A warning: URDF 1.0 has no capsule, cylinders are written. A note: what hangs on links that are not in the "
        "URDF, and whose mass stands still in it.",
        'A cylinder and spheres say it exactly; `version: "1.2"` has capsules. `frames: bodies` has what moves.',
        FORMATS,
    ),
)

ELEMENTS = [INERTIAL, "visual", "collision", "dynamics", "urdf_elements"]
FROM_COLLISION = "from_collision"


class _Format(NamedTuple):
    """How the URDF is asked for: how numbers are printed, its elements, its version, the boxes of height maps."""

    number: NumberFormat
    elements: Sequence[str]
    version: str
    boxes: str
    known: dict[int, tuple[object, Any]]

    def once(self, value: T, make: Callable[[T], Any]) -> Any:
        """Return what is made of a value, which many links or joints may share."""
        if id(value) not in self.known:
            self.known[id(value)] = (value, make(value))
        return self.known[id(value)][1]

    def numbers(self, values: Iterable[float]) -> str:
        return numbers(values, self.number)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the URDF of a robot.

    Options: ``number_format``, ``elements`` (of inertial, visual, collision, dynamics, urdf_elements;
    default all), ``frames`` (published, all or bodies), ``visuals`` (from_collision, where a link has none),
    ``version`` (1.0 or 1.2, which has capsules), ``height_maps`` (the form of their boxes), ``gazebo`` (true, or which
    Gazebo; default no sensors).
    """
    form = _form(output)
    number, elements = form.number, form.elements
    content = _Content(_seen(robot, output), output, form)
    shown, carried = content.view, content.carried
    steps = []
    for names, joint in link_groups(shown, shown.joints):
        rows = []
        for link in map(shown.link.__getitem__, names):
            inertial = form.once(link.inertial, lambda one: _inertial(one, number)) if link.inertial else []
            shapes = _rows(link.visual, form), _rows(link.collision, form)
            rows.append((attribute("name", link.name), inertial, *shapes, _kept(link.urdf_elements, "    ")))
        steps.append((rows, [] if joint is None else [_joint(joint, form)]))
    diagnostics = [*content.diagnostics, *_stood_in(content.replaced, form), *_balls(robot)]
    diagnostics += _left_out(robot, output, elements)
    diagnostics += standing_still(robot, carried) if content.masses else ()
    values = {"robot": robot, "steps": steps, "stand_ins": sorted(content.stand_ins), "comment": comment}
    values["names"] = attributes(name=robot.name, **({} if form.version == "1.0" else {"version": form.version}))
    values["materials"] = [(attributes(name=m.name), _look(m.rgba, m.texture, form)) for m in shown.materials]
    values["elements"] = _kept(shown.urdf_elements, "  ")
    return templates.own("core/robot.urdf.jinja", values), diagnostics


def view(robot: Robot, output: Output) -> Robot:
    """Return the robot that the URDF of an output is meant to contain, in the terms of URDF."""
    return _Content(_seen(robot, output), output, _form(output)).view


class _Content:
    """What a URDF contains of a robot.

    ``replaced`` counts, by link, shapes that others stand in for; ``masses`` are the inertials of the links.
    """

    def __init__(self, robot: Robot, output: Output, form: _Format) -> None:
        self.robot = robot
        self.form = form
        self.diagnostics: list[Diagnostic] = []
        self.replaced: dict[str, Counter[type]] = {}
        self.stand_ins: set[str] = set()
        self.carried = links_of(robot, output)
        joints = joints_of(robot, output)
        try:
            self.masses: Mapping[str, Inertial] = inertials(robot, output)
        except ValueError as problem:
            self.masses = {}
            self.diagnostics.append(too_much(problem))
        names = [name for group, _ in link_groups(robot, joints) for name in group]
        links = tuple(self._link(name) for name in names)
        elements = self._said(robot.urdf_elements)
        if output.options.get("gazebo"):
            blocks, told = _gazebo(robot, output, form, self.masses)
            elements += tuple(blocks)
            self.diagnostics += told
        elements += tuple(_of_sections(robot, output, form))
        self.view = Robot(
            robot.name,
            links,
            tuple(map(self._joint, joints)),
            materials=tuple(
                Material(one.name, one.rgba, urdf_file_name(one.texture))
                for one in robot.materials
                if "visual" in form.elements
            ),
            urdf_elements=elements,
        )

    def _said(self, texts: tuple[str, ...]) -> tuple[str, ...]:
        return texts if "urdf_elements" in self.form.elements else ()

    def _link(self, name: str) -> Link:
        robot, form = self.robot, self.form
        visual = shapes_at(robot, name, self.carried, "visual", form.boxes) if "visual" in form.elements else []
        collision = collisions(robot, name, self.carried, form.boxes) if "collision" in form.elements else []
        others = [type(s.geometry) for s in (*visual, *collision) if isinstance(s.geometry, (Capsule, Ellipsoid))]
        if others:
            self.replaced[name] = Counter(others)
        self.stand_ins |= {solid.stand_in for solid in collision if solid.stand_in}
        shown, solid = (
            tuple(self._shape(shape, f"{name}_{number}") for number, shape in enumerate(shapes, 1))
            for shapes in (visual, collision)
        )
        return Link(name, self.masses.get(name), shown, solid, urdf_elements=self._said(robot.link[name].urdf_elements))

    def _shape(self, shape: Shape, own: str) -> Shape:
        """Return a shape in the terms of URDF; ``own`` is the name of its material if it has none, but a look."""
        if shape.rgba is None and not shape.texture:
            made: Shape = self.form.once(shape, self._plain)
            return made
        while not shape.material and own in self.robot.material:
            own += "_"
        return replace(self._plain(shape), material=shape.material or own)

    def _plain(self, shape: Shape) -> Shape:
        geometry = shape.geometry
        if self.form.version == "1.0" or isinstance(geometry, Ellipsoid):
            geometry = plain(geometry)
        if isinstance(geometry, Box):
            x, y, z = (size / 2 for size in geometry.size)
            geometry = Box((-x, -y, -z), (x, y, z))
        if isinstance(geometry, Mesh):
            geometry = replace(geometry, file=urdf_file_name(geometry.file))
        elements, texture = self._said(shape.urdf_elements), urdf_file_name(shape.texture)
        return Shape(
            geometry, shape.origin(), shape.name, shape.rgba, shape.material, "", texture, urdf_elements=elements
        )

    def _joint(self, joint: Joint) -> Joint:
        along = not joint.is_fixed and not joint.is_axleless
        dynamics = joint.dynamics if "dynamics" in self.form.elements else None
        if dynamics is not None:
            dynamics = Dynamics(dynamics.damping, dynamics.friction)
        # The nearest type that URDF has to a ball, and robot_state_publisher leaves it alone as well.
        return Joint(
            joint.name,
            "floating" if joint.type == "ball" else joint.type,
            joint.parent,
            joint.child,
            joint.origin,
            joint.axis if along else (1.0, 0.0, 0.0),
            joint.limit if along else None,
            joint.mimic,
            dynamics if dynamics != Dynamics() else None,
            calibration=joint.calibration,
            safety=joint.safety,
            urdf_elements=self._said(joint.urdf_elements),
        )


def _seen(robot: Robot, output: Output) -> Robot:
    """Return the robot as an output shows it: with visuals that come from collision shapes, if it asks for them."""
    if output.options.get("visuals") != FROM_COLLISION:
        return robot
    from rosorin_compile.model.looks import with_visuals

    return with_visuals(robot)


def _gazebo(
    robot: Robot, output: Output, form: _Format, masses: Mapping[str, Inertial]
) -> tuple[list[str], list[Diagnostic]]:
    """Return the sensors, springs and frictions for Gazebo, and what it will not see of them."""
    from ..gazebo_sensors import distribution
    from .gazebo import Carried, kept_joints, physics, sensors

    carried = links_of(robot, output)

    def shapes(link: str) -> list[Shape]:
        return collisions(robot, link, carried, form.boxes) if "collision" in form.elements else []

    def named(link: str) -> list[str]:
        return [shape.name for shape in shapes(link)]

    kept = kept_joints(robot.urdf_elements) if "urdf_elements" in form.elements else frozenset()
    there = Carried(carried, joints_of(robot, output), INERTIAL in form.elements, masses, named, kept)
    blocks, told = sensors(robot, there, distribution(output.options["gazebo"]), form.number)
    frictions = {
        name: {shape.contact.sliding_friction if shape.contact else None for shape in shapes(name)}
        for name in (link.name for link in robot.links if link.name in carried)
    }
    dynamics = there.joints if "dynamics" in form.elements else ()
    more, lost = physics(robot, frictions, dynamics, form.number)
    return [*blocks, *more], [*told, *lost]


def _of_sections(robot: Robot, output: Output, form: _Format) -> list[str]:
    """Return the elements that sections have in a URDF, as the hardware blocks of ros2_control."""
    return [
        element
        for section in sections_in_urdf(output)
        if section.urdf is not None
        for element in section.urdf(robot, output, form.number)
    ]


def brought(robot: Robot, output: Output) -> list[str]:
    """Return the elements that an output has for Gazebo and ros2_control, and the description in its own words."""
    control = _of_sections(robot, output, _form(output))
    if not output.options.get("gazebo"):
        return control
    try:
        masses = inertials(robot, output)
    except ValueError:
        masses = {}  # which is told where the output is written
    return [*_gazebo(robot, output, _form(output), masses)[0], *control]


def _form(output: Output) -> _Format:
    number = number_format(output.options)
    elements = output.options.get("elements", ELEMENTS)
    visual = ["visual"] if output.options.get("visuals") == FROM_COLLISION and "visual" not in elements else []
    return _Format(number, [*elements, *visual], version_of(output), boxes_of(output), {})


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


def _look(rgba: Sequence[float] | None, texture: str, form: _Format) -> str:
    """Return the elements of a material."""
    colour = f"<color{attributes(rgba=form.numbers(rgba))}/>" if rgba is not None else ""
    return f"{colour}<texture{attributes(filename=urdf_file_name(texture))}/>" if texture else colour


def _kept(texts: Iterable[str], indent: str) -> list[str]:
    return [indented(text, indent) for text in texts]


def _rows(solids: Iterable[Shape], form: _Format) -> list[tuple[Any, ...]]:
    """Return each solid as attributes of its elements: name, origin, kind and sizes, material; and what is in them."""
    return [form.once(solid, lambda one: _row(one, form)) for solid in solids]


def _row(solid: Shape, form: _Format) -> tuple[Any, ...]:
    kind, sizes = _geometry(solid, form)
    names = attributes(name=solid.name) if solid.name else ""
    surface = attributes(name=solid.material) if solid.material else ""
    look, kept = _look(solid.rgba, solid.texture, form), _kept(solid.urdf_elements, "      ")
    return names, _origin(solid.pose, form.number), kind, attributes(**sizes), surface, look, kept


def _origin(pose: Pose, number: NumberFormat) -> Markup:
    return _placed(pose.xyz, pose.rpy, number)


@lru_cache(maxsize=20_000)
def _placed(xyz: Vector, rpy: Vector, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(xyz, number), rpy=vector(rpy, number))


@lru_cache(maxsize=20_000)
def _axis(axis: Vector, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(axis, number))


def _geometry(solid: Shape, form: _Format) -> tuple[str, dict[str, str]]:
    """Return the element and the attributes of a geometry (http://wiki.ros.org/urdf/XML/link)."""
    shape, number = solid.geometry, form.number
    if isinstance(shape, Box):
        return "box", {"size": form.numbers(shape.size)}
    if isinstance(shape, Cylinder):
        return "cylinder", {"radius": number(shape.radius), "length": number(shape.length)}
    if isinstance(shape, Capsule):
        return "capsule", {"radius": number(shape.radius), "length": number(shape.length)}
    if isinstance(shape, Sphere):
        return "sphere", {"radius": number(shape.radius)}
    if isinstance(shape, Mesh):
        return "mesh", {"filename": urdf_file_name(shape.file), "scale": form.numbers(shape.scale)}
    raise TypeError(f"{type(shape).__name__} is not a solid")


def _inertial(inertial: Inertial, number: NumberFormat) -> list[tuple[Markup, ...]]:
    """Return the attributes of an inertial, as a list of one."""
    return [(_origin(inertial.pose, number), attributes(value=number(inertial.mass)), _moments(inertial, number))]


def _moments(inertial: Inertial, number: NumberFormat) -> Markup:
    texts = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertial.printed(number), strict=True))
    return attributes(**{key: texts[key] for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")})


def _joint(joint: Joint, form: _Format) -> tuple[Any, ...]:
    """Return a joint as attributes: names, links, origin; then its elements with theirs; then those it has kept."""
    number, dynamics, mimic = form.number, joint.dynamics, joint.mimic
    inner: list[tuple[str, Markup]] = []
    if not joint.is_fixed and not joint.is_axleless:
        inner.append(("axis", _axis(joint.axis, number)))
    if joint.calibration is not None:
        inner.append(("calibration", _given(joint.calibration, ("rising", "falling", "reference_position"), number)))
    if joint.limit is not None:
        keys = ("lower", "upper", "effort", "velocity")
        inner.append(("limit", form.once(joint.limit, lambda limit: _given(limit, keys, number))))
    if dynamics is not None:
        inner.append(("dynamics", _given(dynamics, ("damping", "friction"), number)))
    if mimic is not None:
        factor, offset = number(mimic.multiplier), number(mimic.offset)
        inner.append(("mimic", attributes(joint=mimic.joint, multiplier=factor, offset=offset)))
    if joint.safety is not None:
        keys = ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity")
        inner.append(("safety_controller", _given(joint.safety, keys, number)))
    names = attribute("name", joint.name) + attribute("type", joint.type)
    ends = attribute("link", joint.parent), attribute("link", joint.child)
    return (names, *ends, _origin(joint.origin, number), inner, _kept(joint.urdf_elements, "    "))


def _given(entry: object, keys: Iterable[str], number: NumberFormat) -> Markup:
    """Return the numbers of an entry as attributes, those that are given."""
    values = {key: getattr(entry, key) for key in keys}
    return attributes(**{key: number(value) for key, value in values.items() if value is not None})


def _left_out(robot: Robot, output: Output, elements: Sequence[str]) -> list[Diagnostic]:
    """Return a note on what hangs on links that the URDF does not carry and cannot be moved to one that it does."""
    carried, ours = links_of(robot, output), {joint.name for joint in joints_of(robot, output)}
    lost = []
    for link in robot.walk():
        if link.name in carried or link.name in robot.simulated_frames:
            continue
        fixed = _reaches_by_fixed_joints(robot, link.name, carried)
        shapes = [p for p in ("visual", "collision") if p in elements and getattr(link, p) and not fixed]
        kept = ["urdf_elements"] if "urdf_elements" in elements and link.urdf_elements else []
        lost += [f"{link.name} ({', '.join(shapes + kept)})"] if shapes or kept else []
    lost += [f"{j.name} (urdf_elements)" for j in robot.joints if j.urdf_elements and j.name not in ours]
    if not lost:
        return []
    why = "they have no mass" if frames_of(output) == BODIES else "robot_state_publisher does not publish them"
    message = f"not in the URDF, because {why}: {', '.join(lost)}"
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


def _stood_in(shapes: Mapping[str, Counter[type]], form: _Format) -> list[Diagnostic]:
    """Return the warnings about shapes, counted by link, that others stand for: URDF has no word for them."""
    made = []
    if form.version == "1.0":
        help = 'use a cylinder and spheres, or say version: "1.2" where all readers of the URDF know it'
        made += _of_kind(shapes, Capsule, "URDF 1.0", "cylinder", "full length", help)
    return made + _of_kind(shapes, Ellipsoid, "URDF", "box", "extents", "use a sphere, a box or a mesh")


def _balls(robot: Robot) -> list[Diagnostic]:
    """Return the note about ball joints: URDF has no word for them."""
    names = [joint.name for joint in robot.in_urdf() if joint.type == "ball"]
    if not names:
        return []
    what = f"joint {names[0]} is" if len(names) == 1 else f"{counted(len(names), 'joint')} ({first_of(names, 3)}) are"
    return [Diagnostic("urdf-cannot-say", NOTE, f"URDF has no ball joint: {what} written as floating")]


def _of_kind(
    shapes: Mapping[str, Counter[type]], kind: type, version: str, other: str, same: str, help: str
) -> list[Diagnostic]:
    counts = {link: found[kind] for link, found in shapes.items() if found[kind]}
    if not counts:
        return []
    count, others = sum(counts.values()), len(counts) - 1
    where = f"link {next(iter(counts))}" + (f" and {counted(others, 'other link')}" if others else "")
    become = f"are written as {plural(other, 2)}" if count > 1 else f"is written as a {other}"
    message = f"{version} has no {kind.__name__.lower()}: {count} on {where} {become} of the same {same}"
    return [Diagnostic("urdf-cannot-say", WARNING, message, help=help)]
