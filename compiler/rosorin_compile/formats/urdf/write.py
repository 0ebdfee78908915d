"""Determine the contents of a URDF, and write it (rules of the reader: ``ros/urdfdom@jazzy:urdf_parser``).

By default, a URDF has the links and joints that robot_state_publisher publishes, and planar and floating joints. The
option ``frames`` adds others for simulators. libsdformat drops every link without mass, so that Gazebo reads a URDF
without masses as an empty model. For a link without an inertial, PyBullet uses 1 kg, and MuJoCo 1 g per cm^3 of its
shapes; an inertial of zero prevents this (tested with libsdformat 12, PyBullet 3.2.7, MuJoCo 4).
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any

from markupsafe import Markup

from rosorin_compile.model import Inertial, Joint, Link, Output, Pose, Robot
from rosorin_compile.model.bounds import radius_about, reach_along
from rosorin_compile.model.colours import with_visuals
from rosorin_compile.model.geometry import IDENTITY, Transform, dot, minus, plane_axes, pose_of, unit
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.link import together
from rosorin_compile.model.sections import sections_in_urdf
from rosorin_compile.model.shape import ROWS, Box, Capsule, Cylinder, Ellipsoid, Material, Mesh, Shape, plain
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.case import number as rounded
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Span, error
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.wording import count_of, plural, quote
from rosorin_compile.source.xml.elements import indented

from ..gazebo import distribution, drive_blocks, gazebo_blocks
from ..mesh_files import urdf_file_name
from ..templating import Templates, attributes, comment

STEP = 1 / 240  # default time step (s) of PyBullet; the default of Gazebo is 1/1000
FROM_COLLISION = "from_collision"
PUBLISHED, ALL, BODIES = "published", "all", "bodies"
ELEMENTS = ("inertial", "visual", "collision", "dynamics", "urdf_elements")
_NO_MASS = Inertial(0.0, IDENTITY, 0.0, 0.0, 0.0)


def frames_of(output: Output) -> str:
    """Return the option ``frames``: "published" (by robot_state_publisher), "all" or "bodies"."""
    return str(output.options.get("frames", PUBLISHED))


def elements_of(output: Output) -> Sequence[str]:
    """Return the kinds of elements that an output contains, such as "inertial" and "visual"."""
    elements = output.options.get("elements", ELEMENTS)
    return [*elements, "visual"] if output.options.get("visuals") == FROM_COLLISION else elements


def joints_of(robot: Robot, output: Output) -> tuple[Joint, ...]:
    """Return the joints that an output contains, in the order of the description."""
    if frames_of(output) == BODIES:
        bodies = links_of(robot, output)
        return tuple(joint for joint in robot.joints if joint.parent in bodies and joint.child in bodies)
    return robot.joints if frames_of(output) == ALL else robot.in_urdf()


def links_of(robot: Robot, output: Output) -> frozenset[str]:
    """Return the links that an output contains: only the root link if the output has no joints."""
    return _links(robot, frames_of(output))


@of_robot
def _links(robot: Robot, frames: str) -> frozenset[str]:
    if frames != BODIES:
        joints = robot.joints if frames == ALL else robot.in_urdf()
        return frozenset(name for joint in joints for name in (joint.parent, joint.child)) or frozenset([robot.root])
    bodies: set[str] = set()  # links that have mass, that a joint moves, or that connect such links
    for link in reversed(list(robot.walk())):
        above = robot.joint_to.get(link.name)
        if link.name in bodies or link.inertial is not None or (above is not None and not above.is_fixed):
            bodies |= {link.name, above.parent} if above is not None else {link.name}
    top = robot.root
    while robot.link[top].inertial is None:
        below = [joint for joint in robot.joints_from.get(top, ()) if joint.child in bodies]
        if len(below) != 1 or not below[0].is_fixed:
            break
        bodies.discard(top)
        top = below[0].child
    return frozenset(bodies) or frozenset([robot.root])


@of_robot
def carriers(robot: Robot, carried: frozenset[str]) -> Mapping[str, tuple[str, Transform]]:
    """Map each link to the link of the URDF that replaces it, and to its pose in that link with joints at zero.

    ``carried`` are the links of the URDF. An omitted link is replaced by its nearest ancestor in the URDF, or by the
    topmost link if it has none.
    """

    def at_zero(joint: Joint) -> Transform:
        return joint.transform(robot.position(joint, {}) if joint.moves else 0.0)

    top = next(link.name for link in robot.walk() if link.name in carried)
    found, here = {top: (top, Transform())}, Transform()
    for joint in reversed(robot.chain(top)):
        here = here.then(at_zero(joint).inverse())
        found[joint.parent] = (top, here)
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        if link.name in carried:
            found[link.name] = (link.name, Transform())
        elif link.name not in found and above is not None:
            carrier, transform = found[above.parent]
            found[link.name] = (carrier, transform.then(at_zero(above)))
    return found


def inertials_at(robot: Robot, carried: Set[str]) -> Mapping[str, Inertial]:
    """Return the inertials of the links ``carried`` of a URDF, including links merged into them. Raises ValueError."""
    parts: dict[str, list[tuple[Inertial, Transform]]] = {}
    for name, (carrier, transform) in carriers(robot, frozenset(carried)).items():
        inertial = robot.link[name].inertial
        if inertial is not None:
            parts.setdefault(carrier, []).append((inertial, transform))
    own = {name: robot.link[name].inertial for name in parts}
    return {name: one if (one := own[name]) and len(some) == 1 else together(some) for name, some in parts.items()}


@of_robot
def _shapes_at(robot: Robot, link: str, carried: frozenset[str], purpose: str, height_maps: str) -> Sequence[Shape]:
    """Return the visual or collision shapes of a link, preceded by shapes of fixed links that the URDF omits."""
    moved, own = list[Shape](), list[Shape]()
    visited, waiting = {link}, [(link, Transform())]
    while waiting:
        name, transform = waiting.pop()
        solids = [solid for shape in getattr(robot.link[name], purpose) for solid in shape.solids(height_maps)]
        if name == link:
            own = solids
        else:
            moved += [solid.move(transform) for solid in solids]
        neighbours = robot.fixed_neighbours(name)
        steps = [(n, transform.then(t)) for n, t in neighbours if n not in carried and n not in visited]
        visited.update(n for n, _ in steps)
        waiting += reversed(steps)
    return [*moved, *own]


def solids(robot: Robot, link: str, output: Output, carried: frozenset[str]) -> list[Shape]:
    """Return the collision shapes of a link in a URDF that contains the links ``carried``."""
    return [_in_version(shape, output) for shape in _collisions(robot, link, carried, output)]


def _in_version(shape: Shape, output: Output) -> Shape:
    unknown = (Ellipsoid,) if str(output.options.get("version", "1.0")) != "1.0" else (Capsule, Ellipsoid)
    return replace(shape, geometry=plain(shape.geometry)) if isinstance(shape.geometry, unknown) else shape


def _collisions(robot: Robot, link: str, carried: frozenset[str], output: Output) -> Sequence[Shape]:
    """Return the collision shapes of a link; a wheel whose rollers are omitted gets a cylinder around them."""
    own = _shapes_at(robot, link, carried, "collision", str(output.options.get("height_maps", ROWS)))
    joint = robot.joint_to.get(link)
    lost = _lost(robot, carried).get(link) if joint is not None and joint.type == "continuous" else None
    if not lost or joint is None:
        return own
    x, y, z = axis = unit(joint.axis)
    placed = [(solid, Transform()) for solid in own if not isinstance(solid.geometry, Mesh)]
    if radius_about(lost, axis) <= radius_about(placed, axis):
        return own
    placed += lost
    reaches = [reach_along(solid, place) for solid, place in placed]
    top, bottom = max(reach((x, y, z)) for reach in reaches), -max(reach((-x, -y, -z)) for reach in reaches)
    middle = (top + bottom) / 2
    (a, b, c), (d, e, f) = plane_axes(axis)
    turned = Transform(((a, d, x), (b, e, y), (c, f, z)), (x * middle, y * middle, z * middle))
    around = Shape(Cylinder(radius_about(placed, axis), top - bottom), pose_of(turned))
    return [around, *(solid for solid in own if isinstance(solid.geometry, Mesh))]


@of_robot
def _lost(robot: Robot, carried: frozenset[str]) -> Mapping[str, Sequence[tuple[Shape, Transform]]]:
    found: dict[str, list[tuple[Shape, Transform]]] = {}
    for name, (carrier, place) in carriers(robot, carried).items():
        shapes = robot.link[name].collision if name not in carried else ()
        joint = robot.joint_to.get(carrier)
        if shapes and joint is not None and joint.type == "continuous" and robot.moves_between(name, carrier):
            found.setdefault(carrier, []).extend((s, place) for s in shapes if not isinstance(s.geometry, Mesh))
    return found


class Content:
    """The contents of a URDF as a robot (``view``), and ``diagnostics`` about omitted or replaced values."""

    def __init__(self, robot: Robot, output: Output) -> None:
        robot = with_visuals(robot) if output.options.get("visuals") == FROM_COLLISION else robot
        self.robot, self.output, self.elements = robot, output, elements_of(output)
        self.carried, self.joints = links_of(robot, output), joints_of(robot, output)
        self.masses: Mapping[str, Inertial] = {}  # {link: inertial}, with those of omitted links added
        self.lost: list[Diagnostic] = []
        if "inertial" in self.elements:
            try:
                # With ``frames: bodies``, links without an inertial get zero mass: simulators would assume a mass.
                invented = dict.fromkeys(self.carried, _NO_MASS) if frames_of(output) == BODIES else {}
                self.masses = {**invented, **inertials_at(robot, self.carried)}
            except ValueError as problem:
                message = f"the masses of links that the URDF merges into one cannot be added: {problem}"
                self.lost.append(error("urdf-mass-sum", message, None, "correct the masses"))
        gazebo, number = distribution(output.options.get("gazebo")), number_format(output.options)
        # Elements for Gazebo, and elements of sections such as ros2_control.
        self.blocks, lost = gazebo_blocks(self) if gazebo else ([], [])
        for section in sections_in_urdf(output):
            self.blocks += section.urdf(robot, output, number) if section.urdf is not None else []
        called, others = {one.name: one.name for one in self.joints}, (*self._kept(robot.urdf_elements), *self.blocks)
        drives, lost_drives = drive_blocks(robot, called, "urdf-cannot-say", gazebo, number, others)
        self.blocks, self.lost = [*self.blocks, *drives], [*self.lost, *lost, *lost_drives]
        is_seen, height_maps = "visual" in self.elements, str(output.options.get("height_maps", ROWS))
        names = [name for group, _ in link_groups(robot, self.joints) for name in group]
        visuals = {n: _shapes_at(robot, n, self.carried, "visual", height_maps) if is_seen else [] for n in names}
        self.shapes = {name: (visuals[name], self.collisions(name)) for name in names}
        looks = [Material(one.name, one.rgba, urdf_file_name(one.texture)) for one in robot.materials if is_seen]
        elements = (*self._kept(robot.urdf_elements), *self.blocks)
        links, joints = tuple(map(self._link, names)), tuple(map(self._joint, self.joints))
        self.view = Robot(robot.name, links, joints, materials=tuple(looks), urdf_elements=elements)

    def _kept(self, texts: tuple[str, ...]) -> tuple[str, ...]:
        return texts if "urdf_elements" in self.elements else ()

    def collisions(self, link: str) -> Sequence[Shape]:
        return _collisions(self.robot, link, self.carried, self.output) if "collision" in self.elements else []

    def _link(self, name: str) -> Link:
        both = ([self._shape(shape, f"{name}_{n}") for n, shape in enumerate(some, 1)] for some in self.shapes[name])
        (visual, solid), kept = map(tuple, both), self._kept(self.robot.link[name].urdf_elements)
        return Link(name, self.masses.get(name), visual, solid, urdf_elements=kept)

    def _shape(self, shape: Shape, name: str) -> Shape:
        """Convert a shape for URDF; ``name`` is the name of a material for its colour or texture."""
        geometry, material = _in_version(shape, self.output).geometry, shape.material
        if isinstance(geometry, Box):
            x, y, z = (size / 2 for size in geometry.size)
            geometry = Box((-x, -y, -z), (x, y, z))
        elif isinstance(geometry, Mesh):
            geometry = replace(geometry, file=urdf_file_name(geometry.file))
        if not material and (shape.rgba is not None or shape.texture):
            while name in self.robot.material:
                name += "_"
            material = name
        kept, texture = self._kept(shape.urdf_elements), urdf_file_name(shape.texture)
        return Shape(geometry, shape.origin(), shape.name, shape.rgba, material, "", texture, urdf_elements=kept)

    def _joint(self, joint: Joint) -> Joint:
        # URDF has no ball joint, so write a floating joint, which robot_state_publisher ignores as well.
        kind = "floating" if joint.type == "ball" else joint.type
        has_axis = not joint.is_fixed and not joint.is_axleless
        axis, limit = (joint.axis, joint.limit) if has_axis else ((1.0, 0.0, 0.0), None)
        own, kept = joint.dynamics if "dynamics" in self.elements else None, self._kept(joint.urdf_elements)
        dynamics = Dynamics(own.damping, own.friction) if own and (own.damping or own.friction) else None
        made = (joint.name, kind, joint.parent, joint.child, joint.origin, axis, limit, joint.mimic, dynamics)
        return Joint(*made, calibration=joint.calibration, safety=joint.safety, urdf_elements=kept)

    def diagnostics(self) -> Iterator[Diagnostic]:
        yield from self.lost
        if str(self.output.options.get("version", "1.0")) == "1.0":
            help = "use a cylinder and spheres, or write 'version: \"1.2\"' if your URDF parsers support it"
            yield from self._replaced(Capsule, "URDF 1.0", "cylinder", "full length", help)
        yield from self._replaced(Ellipsoid, "URDF", "box", "extents", "use a sphere, a box or a mesh")
        robot, notes, lost, still = self.robot, [], [], []
        balls = [joint.name for joint in robot.in_urdf() if joint.type == "ball"]
        if balls:
            become = "becomes a floating joint" if len(balls) == 1 else "become floating joints"
            notes.append((f"URDF has no ball joint: {quote(balls, 3)} {become}", ""))
        owners = carriers(robot, self.carried).items()
        moving = {name for name, (carrier, _) in owners if robot.moves_between(name, carrier)}
        for link in robot.walk():
            if link.name not in self.carried and link.name not in robot.simulated_frames:
                shapes = ("visual", "collision") if link.name in moving else ()
                what = [purpose for purpose in shapes if purpose in self.elements and getattr(link, purpose)]
                what += ["urdf_elements"] if self._kept(link.urdf_elements) else []
                lost += [f"{link.name} ({', '.join(what)})"] if what else []
            still += [link.name] if link.inertial is not None and link.name in moving and self.masses else []
        names = {joint.name for joint in self.joints}
        lost += [f"{j.name} (urdf_elements)" for j in robot.joints if j.urdf_elements and j.name not in names]
        if lost:
            bodies = frames_of(self.output) == BODIES
            why = "they have no mass" if bodies else "robot_state_publisher does not publish them"
            notes.append((f"left out of the URDF, because {why}: {', '.join(lost)}", ""))
        if still:
            message = f"the mass of {plural('link', len(still))} {quote(still, 3)} does not move in the URDF"
            notes.append((message, 'write "frames: bodies" if the link has to move in the URDF'))
        yield from (Diagnostic("urdf-cannot-say", NOTE, message, help=help) for message, help in notes)

    def _replaced(self, kind: type, version: str, other: str, same: str, help: str) -> Iterator[Diagnostic]:
        pairs = ((link, shape) for link, shapes in self.shapes.items() for some in shapes for shape in some)
        counts = Counter(link for link, shape in pairs if isinstance(shape.geometry, kind))
        if counts:
            count, others = counts.total(), len(counts) - 1
            where = f'link "{next(iter(counts))}"' + (f" and {count_of(others, 'other link')}" if others else "")
            become = f"are written as {plural(other, 2)}" if count > 1 else f"is written as a {other}"
            message = f"{version} has no {kind.__name__.lower()}s: {count} of {where} {become} of the same {same}"
            yield Diagnostic("urdf-cannot-say", WARNING, message, help=help)


@of_robot
def content_of(robot: Robot, output: Output) -> Content:
    """Return the contents of a URDF, computed once for writing it and for checking the result."""
    return Content(robot, output)


def link_groups(robot: Robot, joints: tuple[Joint, ...]) -> list[tuple[list[str], Joint | None]]:
    """Return (new links, joint) for each joint; links of earlier joints are not new. Without joints: ([root], None)."""
    visited: set[str] = set()
    groups: list[tuple[list[str], Joint | None]] = [] if joints else [([robot.root], None)]
    for joint in joints:
        new = [name for name in (joint.parent, joint.child) if name not in visited]
        visited.update(new)
        groups.append((new, joint))
    return groups


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Report missing masses, unstable damping, and what the sections that write to a URDF output report themselves."""
    others = [one for one in case.robot.outputs if one.backend == output.backend]
    has_inertials = "inertial" in elements_of(output)
    heavy = sum(link.inertial is not None and link.inertial.mass > 0 for link in case.robot.links)
    if heavy and not has_inertials and not any("inertial" in elements_of(one) for one in others):
        message = f"{output.file} leaves out {count_of(heavy, 'inertial')}, so simulators drop links or invent masses"
        help = 'write a second URDF for simulators, or suppress this note with "accept"'
        yield case.problem("urdf-without-mass", message, ("outputs", output.name, "elements"), help, severity=NOTE)
    # An explicit time step dt multiplies a speed by 1 - damping * dt / inertia: it grows if this is below -1. MuJoCo
    # and Drake damp implicitly, which is always stable. A URDF has no rotor inertia.
    places: dict[Span | None, list[tuple[float, Joint, float]]] = {}
    has_damping = case.robot.is_tree and has_inertials and "dynamics" in elements_of(output)
    for joint in joints_of(case.robot, output) if has_damping else ():
        damping = joint.dynamics.damping if joint.dynamics is not None and joint.moves else 0.0
        inertia = _moved_inertia(case.robot).get(joint.child, 0.0) if damping > 0 else 0.0
        if inertia > 0 and damping * STEP > 2 * inertia:
            span = case.related_place("", case.joint(joint, "dynamics", "damping")).span
            places.setdefault(span, []).append((inertia / damping, joint, inertia))
    for found in places.values():
        ratio, joint, inertia = min(found, key=lambda one: one[0])
        units = ("N*s/m", "kg") if joint.type == "prismatic" else ("N*m*s/rad", "kg*m^2")
        path = case.joint(joint, "dynamics", "damping")
        more = f" (also {count_of(len(found) - 1, 'other joint')})" if len(found) > 1 else ""
        value = f"a damping of {rounded(inertia / ratio)} {units[0]}{case.stand_in(path)}"
        message = f'joint "{joint.name}" has {value}, too much for {rounded(inertia)} {units[1]} in simulators'
        message += f" with explicit integration, such as PyBullet{more}"
        help = f'up to {rounded(2 * inertia / STEP)} is stable at 1/240 s; write the damping of a servo in "actuator"'
        yield case.problem("explicit-damping-unstable", message, path, help, severity=WARNING)
    for section in sections_in_urdf(output):
        if section.check_urdf is not None:
            yield from section.check_urdf(case, output)


@of_robot
def _moved_inertia(robot: Robot) -> Mapping[str, float]:
    """Return the mass (kg) that each prismatic joint moves, or the inertia (kg*m^2) for other joints, by child link."""
    found: dict[str, float] = {}
    below: dict[str, list[tuple[Inertial, Transform]]] = {}
    try:
        poses = robot.poses_in_root({}) if robot.mimics_resolve else {}
    except ValueError:  # a joint without an axis, which is reported elsewhere
        poses = {}
    for link in reversed(list(robot.walk())) if poses else ():
        parts, joint, pose = below.pop(link.name, []), robot.joint_to.get(link.name), poses[link.name]
        parts += [(link.inertial, pose)] if link.inertial is not None else []
        if not parts or joint is None:
            continue
        try:
            i = together(parts)  # in the frame of the root
        except ValueError:  # no mass, which is reported elsewhere
            continue
        below.setdefault(joint.parent, []).append((i, Transform()))
        if joint.moves:
            axis, place = pose.rotate(unit(joint.axis)), i.pose.transform()
            x, y, z = place.inverse().rotate(axis)
            about = i.ixx * x * x + i.iyy * y * y + i.izz * z * z + 2 * (i.ixy * x * y + i.ixz * x * z + i.iyz * y * z)
            way = minus(place.xyz, pose.xyz)
            about += i.mass * max(0.0, dot(way, way) - dot(axis, way) ** 2)
            found[link.name] = i.mass if joint.type == "prismatic" else about
    return found


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the URDF of a robot, and diagnostics. ``FORMAT`` documents the options."""
    content, number = content_of(robot, output), number_format(output.options)
    shown, steps, version = content.view, [], str(output.options.get("version", "1.0"))  # YAML reads 1.2 as a number
    for names, joint in link_groups(shown, shown.joints):
        links = []
        for link in map(shown.link.__getitem__, names):
            inertials = []
            if link.inertial is not None:
                xx, yy, zz, xy, xz, yz = link.inertial.printed_inertia(number)
                moments = attributes(ixx=xx, ixy=xy, ixz=xz, iyy=yy, iyz=yz, izz=zz)
                mass = attributes(value=number(link.inertial.mass))
                inertials.append((_origin(link.inertial.pose, number), mass, moments))
            shapes = ([_shape(shape, number) for shape in some] for some in (link.visual, link.collision))
            links.append((attributes(name=link.name), inertials, *shapes, indented(link.urdf_elements, "    ")))
        steps.append((links, [] if joint is None else [_joint(joint, number)]))
    stand_ins = {shape.stand_in for _, solid in content.shapes.values() for shape in solid if shape.stand_in}
    values = {"robot": robot, "steps": steps, "stand_ins": sorted(stand_ins), "comment": comment}
    values["names"] = attributes(name=robot.name, **({} if version == "1.0" else {"version": version}))
    values["materials"] = [(attributes(name=m.name), _look(m.rgba, m.texture, number)) for m in shown.materials]
    values["elements"] = indented(shown.urdf_elements, "  ")
    return templates.own("core/robot.urdf.jinja", values), list(content.diagnostics())


def _look(rgba: Sequence[float] | None, texture: str, number: NumberFormat) -> str:
    colour = f"<color{attributes(rgba=numbers(rgba, number))}/>" if rgba is not None else ""
    return f"{colour}<texture{attributes(filename=texture)}/>" if texture else colour


def _shape(solid: Shape, number: NumberFormat) -> tuple[Any, ...]:
    shape = solid.geometry
    if isinstance(shape, Box):
        sizes = {"size": numbers(shape.size, number)}
    elif isinstance(shape, Mesh):
        sizes = {"filename": shape.file, "scale": numbers(shape.scale, number)}
    else:
        sizes = {key: number(getattr(shape, key)) for key in ("radius", "length") if hasattr(shape, key)}
    name, material = (attributes(name=text) if text else "" for text in (solid.name, solid.material))
    look, kept = _look(solid.rgba, solid.texture, number), indented(solid.urdf_elements, "      ")
    return name, _origin(solid.pose, number), type(shape).__name__.lower(), attributes(**sizes), material, look, kept


def _origin(pose: Pose, number: NumberFormat) -> Markup:
    return attributes(xyz=vector(pose.xyz, number), rpy=vector(pose.rpy, number))


def _joint(joint: Joint, number: NumberFormat) -> tuple[Any, ...]:
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
    names = attributes(name=joint.name, type=joint.type)
    ends = attributes(link=joint.parent), attributes(link=joint.child)
    return (names, *ends, _origin(joint.origin, number), inner, indented(joint.urdf_elements, "    "))
