"""Write the MJCF of a robot for MuJoCo 4, without floor and light, to be included or attached in a scene.

Every link becomes a body, with a site of the same name in the frame of the link. Static transforms that other ROS
nodes publish become bodies as well, if the description has their poses. About the format (MuJoCo 4.0.0, XMLreference):

- Rotations are quaternions (w x y z), because ``euler`` has a configurable order. A geom without a mass would get
  the density of water, so every geom has density 0. The torque of a joint is clamped once, at the joint.
- A free joint is only allowed at the top of the tree. Elsewhere, a floating joint becomes three slides and a ball. A
  planar joint becomes two slides and a hinge. ``mimic`` becomes an equality constraint, which is soft.
- Visual geoms are in group 2. Collision geoms are in group 3, which viewers hide, but in group 0 if there are no
  visuals, or in group 2 if they are shown instead of visuals. The sites of frames are in group 4, which is hidden.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import chain, product
from typing import NamedTuple

from markupsafe import Markup

from rosorin_compile import model
from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model.colours import colours_of
from rosorin_compile.model.geometry import plane_axes, pose_of
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.mesh_vertices import clouds_of
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import POSITION, Attribute
from rosorin_compile.mujoco.mjcf.bodies import HOME, home_of, resting_pose
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.xml.elements import indent_lines

from . import bodies, unsupported
from .contacts import contacts
from .servos import Drive, control_count, is_clamped, kept_controls
from .servos import drives as drives_of
from .unsupported import LEAST
from .write_elements import ClassElement, Classes, ElementPrinter, Part, place_of, sensor_parts

_TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
_AXES: tuple[model.Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_AT_ORIGIN = {"planar": (0.0, 0.0, 0.0), "floating": (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)}
_AT_ORIGIN |= {"ball": (1.0, 0.0, 0.0, 0.0)}


def _several(joint: model.Joint, printer: ElementPrinter) -> list[Markup]:
    is_free = bodies.is_free(printer.robot, joint)
    if is_free or joint.type == "ball":
        return [attributes(name=joint.name, type="free" if is_free else "ball", **_inner(joint, printer))]
    base, is_planar = base_name(joint, printer.robot), joint.type == "planar"
    ends, kinds = (bodies.PLANAR, ("slide", "slide", "hinge")) if is_planar else (bodies.FLOATING[:3], ("slide",) * 3)
    parts = zip(ends, kinds, (*plane_axes(joint.axis), joint.axis) if is_planar else _AXES, strict=True)
    made = [attributes(name=base + end, **_motion(kind, axis, printer.number)) for end, kind, axis in parts]
    return made if is_planar else [*made, attributes(name=base + bodies.FLOATING[3], type="ball")]


def base_name(joint: model.Joint, robot: model.Robot) -> str:
    """Return the common name prefix of the MuJoCo joints that represent a planar or floating joint."""
    base = joint.name
    while any(base + end in robot.joint for end in {*bodies.PLANAR, *bodies.FLOATING}):
        base += "_"
    return base


def _single(joint: model.Joint, printer: ElementPrinter) -> dict[str, str]:
    values, ends = _motion(_TYPES[joint.type], joint.axis, printer.number), unsupported.position_range(joint)
    return {**values, **({"range": numbers(ends, printer.number)} if ends else {}), **_inner(joint, printer)}


def _motion(kind: str, axis: model.Vector, number: NumberFormat) -> dict[str, str]:
    values = {} if kind == "hinge" else {"type": kind}
    return values if axis == _AXES[2] else {**values, "axis": vector(axis, number)}


def _inner(joint: model.Joint, printer: ElementPrinter) -> dict[str, str]:
    number, dynamics = printer.number, joint.dynamics or Dynamics()
    # Actuator damping is written on the joint, because MJX ignores it on actuators and force limits would clamp it.
    words = {"damping": joint.total_damping, "frictionloss": dynamics.friction, "armature": dynamics.armature}
    words |= {"stiffness": dynamics.stiffness, "springref": dynamics.spring_reference}
    values = {word: number(value) for word, value in words.items() if value}
    effort = joint.limit.known_value("effort") if joint.limit is not None else None
    if effort and not is_clamped(printer.robot, joint, effort):
        values["actuatorfrcrange"] = numbers([-effort, effort], number)
    return values | printer.texts(joint.mjcf)


def _followers(robot: model.Robot, joints: Sequence[model.Joint], number: NumberFormat) -> list[Markup]:
    made = []
    for joint, mimic in ((joint, joint.mimic) for joint in joints if joint.mimic is not None and joint.moves):
        leader = robot.joint[mimic.joint]
        values = {"name": mimic.name or joint.name, "joint1": joint.name}
        values |= {"joint2": leader.name} if leader.moves else {}
        factor = mimic.multiplier if leader.moves else 0.0
        # MuJoCo's polynomial is relative to the initial position (``ref``) of both joints.
        offset = mimic.offset + factor * bodies.reference(leader) - bodies.reference(joint)
        tuned = {"solref": mimic.solref or bodies.STIFF["solref"], "solimp": mimic.solimp or bodies.STIFF["solimp"]}
        words = {word: numbers(values, number) for word, values in tuned.items()}
        made.append(attributes(**values, polycoef=numbers([offset, factor, 0.0, 0.0, 0.0], number), **words))
    return made


def _keys(
    robot: model.Robot, joints: list[model.Joint], drives: list[Drive], base: Callable[[JointPose], model.Pose] | None
) -> list[tuple[str, list[float], list[float], dict[str, Attribute]]]:
    """Return (name, qpos, ctrl, other attributes) for each keyframe; ``base`` returns the pose of a free base.

    The first key is home, which is added if the robot can move. The keys of an imported robot keep their order, and
    home is added at the end, because simulators start with the first key.
    """
    made, home, others = [], home_of(robot), [pose for pose in robot.poses if pose.name != HOME]
    poses = (home, *others)
    if robot.source.status == "imported":
        poses = robot.poses if len(others) < len(robot.poses) else (*others, home)
    for pose in poses:
        at: dict[str, Sequence[float]] = {}
        for joint in joints:
            at[joint.name] = _AT_ORIGIN.get(joint.type) or (robot.position(joint, pose.positions),)
            if bodies.is_free(robot, joint):
                at[joint.name] = (*joint.origin.xyz, *joint.origin.transform().quaternion())
        ctrl: list[float] = []
        for drive in drives:
            control, moved, gear = 0.0, drive.joint, drive.actuator.gear
            if drive.actuator.type == POSITION and moved is not None and moved.moves:  # a position servo holds the pose
                control = at[moved.name][0] * (gear[0] if gear else 1.0)
            count = control_count(drive.actuator.type, drive.actuator.mjcf)
            ctrl += [pose.controls.get(drive.name, control), *[0.0] * count][:count]
        place = base(pose) if base else None
        qpos = [*place.xyz, *place.transform().quaternion()] if place else []
        qpos += [number for joint in joints for number in at[joint.name]]
        if qpos or ctrl or pose in robot.poses:
            whole, more = pose.mjcf.get("qpos"), {word: one for word, one in pose.mjcf.items() if word != "qpos"}
            qpos = list(map(float, whole)) if isinstance(whole, tuple) else qpos
            made.append((pose.name, qpos, ctrl + [0.0] * kept_controls(robot), more))
    return made


# Maximum indentation in levels, because the indentation of a long chain of links would fill most of the file.
DEEPEST = 30
OPTION = {"integrator": "implicitfast"}  # default simulation options
# Options for a robot on wheels or feet, which would otherwise creep down a slope: a robot with four mecanum wheels
# creeps 30 mm in 5 s at 10 degrees, and 7 mm with these options.
STANDING = {"cone": "elliptic", "impratio": 100}
# Options for wheels without rollers: the TurtleBot3 turns 3 % too slowly with these options, and 24 % without.
PLAIN_WHEELS = {"cone": "elliptic"}

# A tiny geom for massless bodies, because MuJoCo would otherwise compute fluid forces for a box of several metres.
_NO_DRAG = {"mass": "0", "contype": "0", "conaffinity": "0", "group": "5", "rgba": "0 0 0 0"}
_NO_DRAG |= {"fluidshape": "ellipsoid", "fluidcoef": "0 0 0 0 0"}


class Frame(NamedTuple):
    """A frame in the tree: a link, or (if ``link`` is None) the child of a static transform of another ROS node."""

    name: str
    depth: int
    pose: model.Pose
    joint: model.Joint | None
    link: model.Link | None


def write(robot: model.Robot, output: model.Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return (MJCF of a robot, diagnostics about properties that MJCF cannot express or that MuJoCo rejects)."""
    number, free, frames = number_format(output.options), robot.has_free_base(output), list(_walk(robot))
    joints = [frame.joint for frame in frames if frame.joint]
    shapes = [shape for link in robot.walk() for shape in (*link.visual, *link.collision)]
    drives = drives_of(robot, joints, output)
    usual = "own" if any(link.visual for link in robot.links) else "from_collision"
    shown = colours_of(robot) if output.options.get("visuals", usual) == "from_collision" else {}
    printer = ElementPrinter(robot, number, shown.values())
    measuring = sensor_parts(robot, templates, printer, output.options.get("sensors", ()))
    moving = [joint for joint in joints if joint.moves]
    shared = [ClassElement("joint", joint.name, _single(joint, printer), joint.name) for joint in moving]
    shared += [printer.actuator(drive) for drive in drives]
    classes = Classes(robot.name, shared, [*robot.mjcf, *(text for _, text in measuring.sections)])
    geoms = _Geoms(output, printer, classes, shown)
    in_world, stands_there = robot.root_in_world, partial(resting_pose, robot, clouds=clouds_of(robot, as_opened=True))
    root = in_world.pose if in_world.placed or not free else stands_there(home_of(robot))
    top = 1 if in_world.world else 0  # depth of the top-level bodies in the frame tree
    name = in_world.joint or bodies.free_name(f"{robot.root}_free", robot.joint)
    tag, kind = ("freejoint", {}) if set(in_world.values) <= {"group", "align"} else ("joint", {"type": "free"})
    free_joint = Markup("<{}{}/>").format(tag, printer.print_values({"name": name, **kind, **in_world.values}))
    none = frozenset(unsupported.weightless(robot, free))
    in_fluid = any(output.options.get("option", {}).get(word) for word in ("density", "viscosity"))
    printed = {joint.name: classes.print_classes(place) for place, joint in enumerate(moving)}
    framed = attributes(**{"class": classes.class_name(bodies.FRAME)})
    elements: list[tuple[object, ...]] = []  # arguments of the template for each body
    for frame, after in zip(frames, [*frames[1:], None], strict=True):
        link, joint, indent = frame.link or model.Link(frame.name), frame.joint, _indent(frame.depth - top)
        made = [*geoms.geoms_of(link, bodies.COLLISION), *geoms.geoms_of(link, bodies.VISUAL)]
        if in_fluid and link.name in none:
            made.append(attributes(name=f"{link.name}_no_drag", size=number(1e-9), **_NO_DRAG))  # m
        pose, names = root if frame.depth == 0 else frame.pose, ""
        if frame.depth >= top:
            place = place_of(pose.xyz, pose.rpy, number)
            names = attributes(name=bodies.body_name(robot, frame.name)) + attributes(**place)
            names += printer.print_values({"gravcomp": link.gravity_compensation or None, **link.mjcf})
        inertial = model.Inertial(LEAST, model.Pose(), LEAST, LEAST, LEAST) if link.name in none else link.inertial
        body = (
            [free_joint] if free and not elements else [],
            indent,
            names,
            _inertial(inertial, number) if inertial and unsupported.has_mass(inertial) else "",
            [] if joint is None else [printed[joint.name]] if joint.moves else _several(joint, printer),
            made,
            attributes(name=frame.name) + framed,
            [*measuring.of_bodies.get(frame.name, ()), *map(printer.mark, link.marked)],
            [indent_lines(text, _indent(frame.depth - top + 1)) for text in link.mjcf_elements],
            [_indent(depth - top) for depth in range(frame.depth, (after.depth if after else top) - 1, -1)],
        )
        elements.append(body)
    touching, of_collision = contacts(robot, geoms.form, geoms.implied), bodies.COLLISION
    values = {
        "robot": robot,
        "classes": classes.tree(geoms.used, bool(geoms.rolls), output.options.get("groups", {})),
        "materials": [printer.print_values(values) for values in printer.materials()],
        "textures": [(name, unsupported.texture_path(file)) for file, name in printer.textures.items()],
        "meshes": list(geoms.printed_meshes()),
        "fields": list(geoms.fields.items()),
        "bodies": elements,
        "followers": _followers(robot, joints, number),
        "actuators": [Part(one.actuator.type, classes.print_classes(at)) for at, one in enumerate(drives, len(moving))],
        "equalities": [printer.constraint(one) for one in robot.constraints],
        "sensors": measuring.sensors,
        "sections": measuring.sections,
        "keys": _keys(robot, joints, drives, stands_there if free else None),
        "excludes": touching.excluded,
        "contact_pairs": [[geoms.names[one.link, of_collision, one.number] for one in pair] for pair in touching.pairs],
        "stand_ins": [comment(text) for text in sorted({shape.stand_in for shape in shapes if shape.stand_in})],
        "title": comment(robot.name),
        "option": _option(robot, output, free, printer),
        "numbers": partial(numbers, number=number),
        "printed": printer.print_values,
        "kept": [indent_lines(text, "  ") for text in measuring.kept],
    }
    text = templates.own("mujoco/robot.xml.jinja", values)
    reports = (unsupported.check_loadable(robot, free), unsupported.report_omissions(robot, joints, touching.left))
    return text, [*chain(*reports), *measuring.diagnostics, *unsupported.check_names(text, geoms.left_out)]


def _walk(robot: model.Robot) -> Iterator[Frame]:
    edges: dict[str, list[tuple[str, model.Pose]]] = {}
    known = set(robot.link)
    for edge in robot.edges:
        if edge.pose is not None and not edge.moving and edge.child not in known:
            known.add(edge.child)
            edges.setdefault(edge.parent, []).append((edge.child, edge.pose))
    waiting = [Frame(robot.root, 0, model.Pose(), None, robot.link[robot.root])]
    while waiting:
        frame = waiting.pop()
        yield frame
        depth = frame.depth + 1
        waiting += [Frame(name, depth, pose, None, None) for name, pose in reversed(edges.get(frame.name, ()))]
        for joint in reversed(robot.joints_from.get(frame.name, ())):
            ref, moving = bodies.reference(joint), None if joint.is_fixed else joint
            place = pose_of(joint.transform(ref)) if ref else joint.origin
            waiting.append(Frame(joint.child, depth, place, moving, robot.link[joint.child]))


def _inertial(inertial: model.Inertial, number: NumberFormat) -> Markup:
    pos, mass, six = vector(inertial.pose.xyz, number), number(inertial.mass), unsupported.along_link_of(inertial)
    if not any(six[3:]):
        return attributes(pos=pos, mass=mass, diaginertia=" ".join(inertial.printed_inertia(number, six)[:3]))
    if inertial.principal_moments[0] < unsupported.LEAST_EIGENVALUE and not unsupported.has_products(inertial):
        own, place = inertial.printed_inertia(number)[:3], place_of(inertial.pose.xyz, inertial.pose.rpy, number)
        return attributes(**{"pos": pos, **place, "mass": mass, "diaginertia": " ".join(own)})
    return attributes(pos=pos, mass=mass, fullinertia=" ".join(inertial.printed_inertia(number, six)))


class _Geoms:
    def __init__(
        self, output: model.Output, printer: ElementPrinter, classes: Classes, shown: Mapping[str, Material]
    ) -> None:
        self.printer, self.classes, self.shown = printer, classes, shown
        self.robot = robot = printer.robot
        self.implied = output.options.get("contacts", "implied") == "implied"
        self.rolls = bodies.rolling_links(robot) if self.implied else frozenset[str]()
        self.form, self.mesh_inertia = bodies.form_of(output), output.options.get("mesh_inertia", "shell")
        self.names, printer.own_names = _geom_names(robot, self.form)
        self.meshes: dict[tuple[model.Mesh, str, tuple[tuple[str, Attribute], ...]], str] = {}
        self.fields: dict[str, bodies.Field] = {}
        self.left_out: dict[str, str] = {}
        self.used: set[str] = set()

    def geoms_of(self, link: model.Link, purpose: str) -> Iterator[Markup]:
        is_shown, rolls = purpose == bodies.COLLISION and link.name in self.shown, link.name in self.rolls
        kinds = {(False, True): bodies.SHOWN, (True, False): bodies.WHEEL, (True, True): bodies.SHOWN_WHEEL}
        kind = kinds.get((rolls, is_shown), purpose) if purpose == bodies.COLLISION else purpose
        for index, solid in bodies.numbered_solids(link, purpose, self.form):
            geometry, name = solid.geometry, self.names[link.name, purpose, index]
            is_lost = isinstance(geometry, model.Mesh) and not unsupported.is_written(self.robot, geometry)
            if is_lost or not bodies.has_volume(geometry):
                self.left_out[name] = link.name
                continue
            self.used.add(kind)
            more = self.printer.look(solid) if purpose == bodies.VISUAL else {}
            more |= {"material": self.printer.material(self.shown[link.name].name)} if is_shown else {}
            more |= self.printer.contact_attributes(solid, purpose)
            called = {"name": name, "class": self.classes.class_name(kind)}
            yield attributes(**{**called, **self._sized(geometry, solid), **more})

    def _sized(self, geometry: model.Geometry, solid: model.Shape) -> dict[str, str]:
        number, pose = self.printer.number, solid.origin()
        if isinstance(geometry, model.HeightMap):
            field = bodies.field_of(solid, geometry)
            name, pose = f"{self.robot.name}_height_field_{len(self.fields) + 1}", field.pose
            self.fields[name] = field
            made = {"type": "hfield", "hfield": name}
        elif isinstance(geometry, model.Mesh):
            if not geometry.inertia and self.mesh_inertia != "legacy":
                geometry = replace(geometry, inertia=self.mesh_inertia)
            key = (geometry, geometry.inertia, tuple(sorted(geometry.mjcf.items())))
            made = {"type": "mesh"}
            made["mesh"] = self.meshes.setdefault(key, f"{self.robot.name}_mesh_{len(self.meshes) + 1}")
        else:
            made = {} if isinstance(geometry, model.Sphere) else {"type": type(geometry).__name__.lower()}
            made["size"] = numbers(bodies.half_sizes(geometry), number)
        return {**made, **place_of(pose.xyz, pose.rpy, number)}

    def printed_meshes(self) -> Iterator[Markup]:
        for (mesh, *_), name in self.meshes.items():
            scale = numbers(mesh.scale, self.printer.number)
            values = {"name": name, "file": unsupported.mesh_path(mesh.file), "scale": scale}
            values |= {"inertia": mesh.inertia} if mesh.inertia else {}
            yield attributes(**values, **self.printer.texts(mesh.mjcf))


def _geom_names(robot: model.Robot, form: str) -> tuple[dict[tuple[str, str, int], str], dict[str, str]]:
    """Return (geom names by (link, purpose, number), geom names by default name LINK_PURPOSE_NUMBER if they differ)."""
    places: dict[tuple[str, str, int], str] = {}
    first = dict[str, str]()
    for purpose, link in product((bodies.COLLISION, bodies.VISUAL), robot.links):
        for number, solid in bodies.numbered_solids(link, purpose, form):
            places[link.name, purpose, number] = solid.name
            first.setdefault(solid.name, purpose)
    own = [(at, name) for at, name in places.items() if name and first[name] == at[1]]
    counts = Counter(name for _, name in own)
    names = {at: name for at, name in own if counts[name] == 1}
    taken, aliases = set(names.values()), {}
    for at in places:
        plain = f"{at[0]}_{at[1]}_{at[2]}"
        if at not in names:
            names[at] = bodies.free_name(plain, taken)
        if names[at] != plain and plain not in taken:
            aliases[plain] = names[at]
    return names, aliases


def _option(robot: model.Robot, output: model.Output, free: bool, printer: ElementPrinter) -> Sequence[Markup | str]:
    described, drive = output.options.get("option", {}), robot.drive
    is_whole = bool(described) and robot.source.status == "imported"
    standing = STANDING if drive is None or drive.slides else PLAIN_WHEELS
    values = {**OPTION, **(standing if (free or drive) and not is_whole else {}), **described}
    flags = values.pop("flag", {})
    texts = {word: printer.text(tuple(one) if isinstance(one, (list, tuple)) else one) for word, one in values.items()}
    return attributes(**texts), attributes(**flags) if flags else ""


def _indent(depth: int) -> str:
    return "  " * (min(depth, DEEPEST) + 2)
