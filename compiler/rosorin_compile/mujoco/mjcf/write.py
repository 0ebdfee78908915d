"""MJCF: the robot for MuJoCo 4, and only the robot: no floor, no light, for ``<include>`` or attaching to a scene.

Every link is a body of the whole tree, from its root, and also a site of the same name in the frame of the link: a body
and a site can be asked for under the name of the frame, whether or not it has mass. Static transforms of other nodes
whose numbers are known are frames too.

What there is to know about the format (MuJoCo 4.0.0, XMLreference):

- Sizes of geoms are halves. Rotations are quaternions (w x y z), because what ``euler`` means is a setting.
- A geom without mass of its own would get the mass of water, so every geom has density 0: the only masses are those of
  the description. A moving body that has none with what is fixed to it is refused by MuJoCo, and therefore here; if it
  carries mass by further joints, it has the least that MuJoCo takes.
- The torque of a joint is clamped once, at the joint (actuatorfrcrange), for actuators of the user's own too.
- There is no word for a velocity limit. A range whose ends are equal means no range.
- There is a free joint at the top of the tree alone. A floating joint is therefore three slides and a ball on one body,
  and a planar joint two slides and a hinge (``bodies`` has their names).
- ``mimic`` is an equality constraint, which is soft: positions that are set by hand have to be set for followers too.
- MuJoCo lets a link not collide with the link that it is jointed to, along with what is fixed to either; except where
  one of the two is fixed to the world, as the base of a robot with ``base: fixed`` is. Excluded contacts and pairs say
  for every joint who may touch whom (``contacts``), so that the base makes no difference.
- A height map is merged boxes, or what ``height_maps`` asks for; as a height field (``hfield``) it is never smaller
  than they are, and does not collide with planes.
- Visual geoms collide with nothing and are in group 2. Collision geoms are in group 3, which viewers hide; in group 0
  if there is nothing else to look at. A link of a robot without visuals is seen as its collision shapes, in one colour:
  these are in group 2.
- What MuJoCo takes an attribute for is not said: a place at zero, a hinge, the axis z, a sphere.
- The sites of frames are in group 4, which viewers hide.
- What sensors are made of stands in the bodies of their frames and in the list of sensors (``write_sensors``).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import NamedTuple

from markupsafe import Markup

from rosorin_compile.formats.templating import Templates, attribute, attributes, comment
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Geometry,
    HeightMap,
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
from rosorin_compile.model.looks import colours_of
from rosorin_compile.model.mesh_vertices import clouds_of
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Attribute
from rosorin_compile.mujoco.rest_pose import home_of, stands_at
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.xml.elements import indented

from .bodies import COLLISION, FRAME, SHOWN, SHOWN_WHEEL, VISUAL, WHEEL, body_name
from .classes import Class, Classes, Named, Part
from .contacts import Geom, contacts
from .height_fields import Field, field_of, form_of, solids
from .masks import rolling
from .masses import LEAST, LEAST_EIGENVALUE, along_link_of, has_mass, has_products, weightless
from .omissions import has_volume, is_written, mesh_path, named, omitted, refused, texture_path, unpaired
from .servos import Drive
from .servos import drives as drives_of
from .write_joints import followers, free_joint, keys, several, single, stands
from .write_sensors import Element, elements_of
from .write_simulation import SimulationPrinter

# A chain of thousands of links is not indented further: its text would grow with the square of its length.
DEEPEST = 30

# The settings of the simulation, where the description has no others.
OPTION = {"integrator": "implicitfast"}
# Those of a robot on wheels or feet, which creeps down a slope without them: four mecanum wheels 30 mm in 5 s at 10
# degrees, 7 mm with them.
STANDING = {"cone": "elliptic", "impratio": 100}
# Of plain wheels the rims would hold a turn back, as no tyre does: 24 % of a TurtleBot3's, 3 % with this.
PLAIN_WHEELS = {"cone": "elliptic"}

# What a body without mass has where MuJoCo asks for one (see ``masses.weightless``).
_NO_SIZE = 1e-9  # m
_LEAST_INERTIAL = Inertial(LEAST, Pose(), LEAST, LEAST, LEAST)


class Body(NamedTuple):
    """A body as the attributes of its elements, and the indents of the bodies that end after it, innermost first.

    ``inertial`` is empty where there is none; ``joints``, ``geoms`` and ``elements`` are lists.
    """

    indent: str
    names: str
    inertial: Markup | str
    joints: list[Markup]
    geoms: list[str]
    site: str
    elements: Sequence[Element]
    marks: Sequence[Part]
    kept: Sequence[str]
    ends: list[str]


class Frame(NamedTuple):
    """A node of the tree of frames: a link, or a static transform that another node publishes (``link`` is None)."""

    name: str
    depth: int
    pose: Pose
    joint: Joint | None
    link: Link | None


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the MJCF of a robot.

    Options: ``base`` (fixed: the root link is held in the world; free: it floats, as that of a robot with a drive does
    unless it says fixed), ``number_format``,
    ``visuals`` (own, or from_collision for links that have none).
    """
    number = number_format(output.options)
    free = robot.has_free_base(output)
    elements = elements_of(robot, templates, number)
    form = form_of(output)
    frames = list(walk(robot))
    joints = [frame.joint for frame in frames if frame.joint]
    shapes = [shape for link in robot.walk() for shape in (*link.visual, *link.collision)]
    drives = drives_of(robot, joints, output)
    shown = colours_of(robot) if _shows_collision(robot, output) else {}
    printer = _Printer(robot, number, elements.bodies, free, output, weightless(robot, free), shown)
    kept = [*robot.mjcf, *(text for _, text in elements.sections)]
    printer.share(joints, drives, kept)
    bodies = [printer.body(frame, after) for frame, after in zip(frames, [*frames[1:], None], strict=True)]
    touching = contacts(robot, form, output.options.get("contacts", "implied") == "implied")
    values = {
        "robot": robot,
        "classes": printer.tree(output.options.get("groups", {})),
        "materials": [printer.simulated.printed(values) for values in printer.simulated.materials()],
        "textures": [(name, texture_path(file)) for file, name in printer.simulated.textures.items()],
        "meshes": [printer.mesh(name, mesh) for (mesh, *_), name in printer.meshes.items()],
        "fields": list(printer.fields.items()),
        "bodies": list(zip([[printer.free_joint()] if free else [], *[()] * len(bodies)], bodies, strict=False)),
        "followers": followers(robot, joints, number),
        "actuators": printer.actuators(drives),
        "equalities": [printer.simulated.constraint(one) for one in robot.constraints],
        "sensors": elements.sensors,
        "sections": elements.sections,
        "keys": keys(robot, joints, drives, printer.stands if free else None),
        "excludes": touching.excluded,
        "contact_pairs": [(printer.collider(one), printer.collider(other)) for one, other in touching.pairs],
        "stand_ins": [comment(text) for text in sorted({shape.stand_in for shape in shapes if shape.stand_in})],
        "title": comment(robot.name),
        "option": _option(robot, output, free, number),
        "number": number,
        "numbers": printer.numbers,
        "pairs": lambda pairs: attributes(**dict(pairs)),
        "printed": printer.simulated.printed,
        "kept": [indented(text, "  ") for text in robot.mjcf],
    }
    text = templates.own("mujoco/robot.xml.jinja", values)
    told = [*refused(robot, free), *omitted(robot, joints), *unpaired(touching.left), *elements.diagnostics]
    return text, [*told, *(named(text, printer.left_out) if printer.left_out else ())]


def walk(robot: Robot) -> Iterator[Frame]:
    """Yield every frame from the root, parents before children: links by their joints, then known static edges."""
    edges: dict[str, list[tuple[str, Pose]]] = {}
    known = set(robot.link)
    for edge in robot.edges:
        if edge.pose is not None and not edge.moving and edge.child not in known:
            known.add(edge.child)
            edges.setdefault(edge.parent, []).append((edge.child, edge.pose))
    links, joints_from = robot.link, robot.joints_from
    waiting = [Frame(robot.root, 0, Pose(), None, links[robot.root])]
    while waiting:
        frame = waiting.pop()
        yield frame
        depth = frame.depth + 1
        for name, pose in reversed(edges.get(frame.name, ())):
            waiting.append(Frame(name, depth, pose, None, None))
        for joint in reversed(joints_from.get(frame.name, ())):
            moving = None if joint.is_fixed else joint
            waiting.append(Frame(joint.child, depth, stands(joint), moving, links[joint.child]))


class _Printer:
    """Puts frames into the terms of MuJoCo, numbers printed: a template takes its time over hundreds of geoms.

    ``shown`` are the colours of the links that are seen as their collision shapes.
    """

    def __init__(
        self,
        robot: Robot,
        number: NumberFormat,
        elements: Mapping[str, Sequence[Element]],
        free: bool,
        output: Output,
        weightless: Sequence[str],
        shown: Mapping[str, Material],
    ) -> None:
        self.robot = robot
        self.shown = shown
        implied = output.options.get("contacts", "implied") == "implied"
        self.rolling = rolling(robot) if implied else frozenset[str]()
        self.number = number
        self.elements = elements
        self.meshes: dict[tuple[Mesh, str, tuple[tuple[str, Attribute], ...]], str] = {}
        self.geom_names: dict[str, list[str]] = {}
        self.left_out: dict[str, str] = {}  # geoms that are not written, each with its link
        self.used: set[str] = set()  # the purposes of those that are
        self.simulated = SimulationPrinter(robot, number, shown.values())
        self.fields: dict[str, Field] = {}
        # What is printed of values that many joints and links may share.
        self.motions: dict[Hashable, Mapping[str, str]] = {}
        self.printed: dict[Hashable, tuple[object, Markup | str]] = {}
        self.form = form_of(output)
        self.names, self.simulated.own_names = _geom_names(robot, self.form)
        self.mesh_inertia = output.options.get("mesh_inertia", "shell")
        self.in_fluid = any(output.options.get("option", {}).get(word) for word in ("density", "viscosity"))
        self.top = 1 if robot.root_in_world.world else 0  # the depth of the frames that are bodies in the world
        self.weightless = frozenset(weightless)
        stands = robot.root_in_world.placed or not free
        self.stands = partial(stands_at, robot, clouds=clouds_of(robot, as_opened=True))
        self.root = robot.root_in_world.pose if stands else self.stands(home_of(robot))

    def share(self, joints: Sequence[Joint], drives: Sequence[Drive], kept: Sequence[str]) -> None:
        """Make the default classes of the robot; ``kept`` are texts that may have classes of their own."""
        moving = [joint for joint in joints if joint.moves]
        made = [Named("joint", joint.name, self.motion(joint), joint.name) for joint in moving]
        made += [self.simulated.actuator(drive) for drive in drives]
        self.classes = Classes(self.robot.name, made, kept)
        self.framed = attributes(**{"class": self.classes.named(FRAME)})
        self.single = {joint.name: self.classes.printed(place) for place, joint in enumerate(moving)}

    def motion(self, joint: Joint) -> Mapping[str, str]:
        """Return the attributes of a joint but its name: one object for joints that move alike."""
        if joint.actuator is not None or joint.mjcf:
            return single(joint, self.simulated)
        key = (joint.type, joint.axis, id(joint.limit), id(joint.dynamics))
        if key not in self.motions:
            self.motions[key] = single(joint, self.simulated)
        return self.motions[key]

    def tree(self, groups: Mapping[str, int]) -> Class:
        """Return the <default> classes that printed elements use; ``groups`` are those of geoms, by kind."""
        return self.classes.tree(self.used, bool(self.rolling), groups)

    def actuators(self, drives: Sequence[Drive]) -> list[Part]:
        """Return the elements of actuators, which follow the joints in the list of those that share classes."""
        places = range(len(self.single), len(self.single) + len(drives))
        pairs = zip(places, drives, strict=True)
        return [Part(drive.actuator.type, self.classes.printed(place)) for place, drive in pairs]

    def joints_of(self, joint: Joint) -> list[Markup]:
        """Return the attributes of the joints that a body has for one joint, in their order."""
        return [self.single[joint.name]] if joint.moves else several(joint, self.simulated)

    def numbers(self, values: Iterable[float]) -> str:
        return numbers(values, self.number)

    def place(self, pose: Pose) -> Mapping[str, str]:
        """Return a position (m) and a unit quaternion (w x y z): each where it is not that of what it stands in."""
        return _place(pose.xyz, pose.rpy, self.number)

    def body(self, frame: Frame, after: Frame | None) -> Body:
        """Return the body of a frame; ``after`` is the next frame of the tree."""
        ends = range(frame.depth, (after.depth if after else self.top) - 1, -1)
        link = frame.link or Link(frame.name)
        return Body(
            _indent(frame.depth - self.top),
            self.names_of(link, frame),
            self.inertial(link.inertial if link.name not in self.weightless else _LEAST_INERTIAL),
            self.joints_of(frame.joint) if frame.joint else [],
            [
                *self.geoms(link, COLLISION, link.collision),
                *self.geoms(link, VISUAL, link.visual),
                *([self.no_drag(link.name)] if self.in_fluid and link.name in self.weightless else []),
            ],
            attribute("name", frame.name) + self.framed,
            self.elements.get(frame.name, ()),
            [self.simulated.mark(mark, self.place(mark.pose)) for mark in link.marked],
            [indented(text, _indent(frame.depth - self.top + 1)) for text in link.mjcf_elements],
            [_indent(depth - self.top) for depth in ends],
        )

    def names_of(self, link: Link, frame: Frame) -> str:
        """Return the attributes of a body; none of the world."""
        if frame.depth < self.top:
            return ""
        pose = self.root if frame.depth == 0 else frame.pose
        texts = [attribute("name", body_name(self.robot, frame.name)), _placed(pose.xyz, pose.rpy, self.number)]
        values = {**link.limited_values("mjcf"), **link.mjcf}
        return "".join([*texts, self.simulated.printed(values)] if values else texts)

    def free_joint(self) -> Markup:
        """Return the element of the joint of a floating base."""
        root = self.robot.root_in_world
        name = root.joint or free_joint(self.robot)
        if set(root.values) <= {"group", "align"}:
            return Markup("<freejoint{}/>").format(self.simulated.printed({"name": name, **root.values}))
        return Markup("<joint{}/>").format(self.simulated.printed({"name": name, "type": "free", **root.values}))

    def inertial(self, inertial: Inertial | None) -> Markup | str:
        """Return the attributes of an inertial; empty where there is no mass."""
        if inertial is None:
            return ""
        return self.once(id(inertial), inertial, self.massive, inertial)

    def once(self, key: Hashable, values: object, make: Callable[..., Markup | str], *given: object) -> Markup | str:
        """Return what is printed of ``values``, whose identities are in the key."""
        found = self.printed.get(key)
        if found is None:
            found = self.printed[key] = (values, make(*given))
        return found[1]

    def massive(self, inertial: Inertial) -> Markup | str:
        """Return the attributes of an inertial that is there."""
        if not has_mass(inertial):
            return ""
        pos, mass, six = vector(inertial.pose.xyz, self.number), self.number(inertial.mass), along_link_of(inertial)
        if not any(six[3:]):
            return attributes(pos=pos, mass=mass, diaginertia=" ".join(inertial.printed(self.number, six)[:3]))
        if inertial.principal_moments[0] < LEAST_EIGENVALUE and not has_products(inertial):
            own = " ".join(inertial.printed(self.number)[:3])
            return attributes(**{"pos": pos, **self.place(inertial.pose), "mass": mass, "diaginertia": own})
        return attributes(pos=pos, mass=mass, fullinertia=" ".join(inertial.printed(self.number, six)))

    def collider(self, geom: Geom) -> str:
        """Return the name of a geom that collides."""
        return self.names[geom.link, "collision", geom.number]

    def geoms(self, link: Link, purpose: str, shapes: tuple[Shape, ...]) -> list[str]:
        """Return the geoms of shapes, named by the link, the purpose and the number of the solid."""
        if not shapes:
            return []
        shown = self.shown.get(link.name) if purpose == COLLISION else None
        kind = purpose
        if purpose == COLLISION and link.name in self.rolling:
            kind = SHOWN_WHEEL if shown else WHEEL
        elif shown:
            kind = SHOWN
        called = self.classes.named(kind)
        made: list[str] = []
        for index, solid in enumerate([solid for shape in shapes for solid in solids(shape, self.form)], start=1):
            geometry = solid.geometry
            sized = self.once((called, id(geometry), id(solid.pose)), solid, self.sized, called, geometry, solid)
            name = self.names[link.name, purpose, index]
            if not sized:
                self.left_out[name] = link.name
                continue
            self.used.add(kind)
            if purpose == COLLISION:
                self.geom_names.setdefault(link.name, []).append(name)
                more = {"material": self.simulated.material(shown.name)} if shown else {}
            else:
                more = self.look(solid)
            if solid.contact is not None or solid.mjcf:
                more |= self.simulated.touching(solid, purpose)
            if isinstance(geometry, (Mesh, HeightMap)):
                made.append(attributes(**{"name": name, "class": called, **self.of_file(geometry, solid), **more}))
            else:
                made.append("".join((attribute("name", name), sized, *map(attribute, more, more.values()))))
        return made

    def sized(self, called: str, geometry: Geometry, solid: Shape) -> Markup | str:
        """Return the class of a geom, of a primitive its sizes and where it sits too; nothing for what is no geom."""
        if not has_volume(geometry) or (isinstance(geometry, Mesh) and not is_written(self.robot, geometry)):
            return ""
        if isinstance(geometry, (Mesh, HeightMap)):
            return attributes(**{"class": called})
        kind = {} if isinstance(geometry, Sphere) else {"type": type(geometry).__name__.lower()}
        sizes = self.numbers(_half_sizes(geometry))
        return attributes(**{"class": called}, **kind, size=sizes, **self.place(solid.origin()))

    def of_file(self, geometry: Mesh | HeightMap, solid: Shape) -> Mapping[str, str]:
        """Return the type of what is no primitive, what it is of, and where it sits."""
        if isinstance(geometry, HeightMap):
            field = field_of(solid, geometry)
            name = f"{self.robot.name}_height_field_{len(self.fields) + 1}"
            self.fields[name] = field
            return {"type": "hfield", "hfield": name, **self.place(field.pose)}
        if not geometry.inertia and self.mesh_inertia != "legacy":
            geometry = replace(geometry, inertia=self.mesh_inertia)
        key = (geometry, geometry.inertia, tuple(sorted(geometry.mjcf.items())))
        name = self.meshes.setdefault(key, f"{self.robot.name}_mesh_{len(self.meshes) + 1}")
        return {"type": "mesh", "mesh": name, **self.place(solid.origin())}

    def mesh(self, name: str, mesh: Mesh) -> Markup:
        """Return the attributes of a mesh."""
        values = {"name": name, "file": mesh_path(mesh.file), "scale": self.numbers(mesh.scale)}
        values |= {"inertia": mesh.inertia} if mesh.inertia else {}
        return attributes(**values, **self.simulated.texts(mesh.mjcf))

    def no_drag(self, link: str) -> Markup:
        """Return a geom that keeps fluids from a body without mass: MuJoCo takes that for a box of metres."""
        of_fluid = {"fluidshape": "ellipsoid", "fluidcoef": "0 0 0 0 0"}
        none = {"mass": "0", "contype": "0", "conaffinity": "0", "group": "5", "rgba": "0 0 0 0"}
        return attributes(name=f"{link}_no_drag", size=self.number(_NO_SIZE), **none, **of_fluid)

    def look(self, visual: Shape) -> dict[str, str]:
        """Return the material of a visual, and the colour that it has instead of that of the material."""
        material = self.robot.material.get(visual.material) if visual.material else None
        named = self.simulated.material(visual.material) if material else ""
        if named and visual.rgba is None and not visual.texture:  # it looks as its material says
            return {"material": named}
        texture = self.robot.texture(visual)
        if "material" not in visual.mjcf and not (material and material.texture == texture):
            named = self.simulated.material_of(texture) or named
        colour = self.robot.colour(visual)
        own = colour if colour and not (named and material and colour == material.rgba) else None
        return {**({"material": named} if named else {}), **({"rgba": self.numbers(own)} if own else {})}


def _shows_collision(robot: Robot, output: Output) -> bool:
    """Say whether links without visuals are seen as their collision shapes: where nothing is seen, or as asked for."""
    usual = "own" if any(link.visual for link in robot.links) else "from_collision"
    return bool(output.options.get("visuals", usual) == "from_collision")


def _geom_names(robot: Robot, form: str) -> tuple[dict[tuple[str, str, int], str], dict[str, str]]:
    """Return the name of each geom by link, purpose and number; and by LINK_PURPOSE_NUMBER where another one has that.

    A geom has the name of its shape, if no other shape has it; one that collides goes before one that is seen. All
    others are called after their link.
    """
    places: dict[tuple[str, str, int], str] = {}
    for purpose in (COLLISION, VISUAL):
        for link in robot.links:
            shapes = link.visual if purpose == VISUAL else link.collision
            for number, solid in enumerate([solid for shape in shapes for solid in solids(shape, form)], start=1):
                places[link.name, purpose, number] = solid.name
    own = [(at, name) for at, name in places.items() if name]
    if not own:
        return {at: f"{at[0]}_{at[1]}_{at[2]}" for at in places}, {}
    first: dict[str, str] = {}
    for (_, purpose, _), name in own:
        first.setdefault(name, purpose)
    counts = Counter(name for (_, purpose, _), name in own if first[name] == purpose)
    names = {at: name for at, name in own if counts[name] == 1 and first[name] == at[1]}
    taken, meant = set(names.values()), {}
    for at in places:
        plain = made = f"{at[0]}_{at[1]}_{at[2]}"
        if at not in names:
            while made in taken:
                made += "_"
            names[at] = made
        if names[at] != plain and plain not in taken:
            meant[plain] = names[at]
    return names, meant


def _option(robot: Robot, output: Output, free: bool, number: NumberFormat) -> tuple[Markup, Markup | str]:
    """Return the attributes of the settings of the simulation, and those of its flags, if any is set.

    What an import says is all that its source has: nothing is added.
    """
    said, drive = output.options.get("option", {}), robot.drive
    whole = bool(said) and robot.source.status == "imported"
    stands: Mapping[str, object] = {}
    if (free or drive) and not whole:
        stands = STANDING if drive is None or drive.slides else PLAIN_WHEELS
    values = {**OPTION, **stands, **said}
    flags = values.pop("flag", {})
    texts = {word: _setting(value, number) for word, value in values.items()}
    return attributes(**texts), attributes(**flags) if flags else ""


def _setting(value: str | float | Sequence[float], number: NumberFormat) -> str:
    if isinstance(value, str):
        return value
    return number(value) if isinstance(value, (int, float)) else numbers(value, number)


@lru_cache(maxsize=20_000)
def _place(xyz: Vector, rpy: Vector, number: NumberFormat) -> Mapping[str, str]:
    quaternion = Pose(xyz, rpy).transform().quaternion()
    made = {"pos": vector(xyz, number)} if any(xyz) else {}
    return made if quaternion == (1, 0, 0, 0) else {**made, "quat": vector(quaternion, number)}


@lru_cache(maxsize=20_000)
def _placed(xyz: Vector, rpy: Vector, number: NumberFormat) -> str:
    """Return the attributes of a place as text."""
    return attributes(**_place(xyz, rpy, number))


def _indent(depth: int) -> str:
    return "  " * (min(depth, DEEPEST) + 2)


def _half_sizes(geometry: Geometry) -> tuple[float, ...]:
    """Return the sizes of a primitive as MuJoCo counts: half extents, radius, radius and half length (m)."""
    if isinstance(geometry, Box):
        x, y, z = geometry.size
        return (x / 2, y / 2, z / 2)
    if isinstance(geometry, (Cylinder, Capsule)):
        return (geometry.radius, geometry.length / 2)
    if isinstance(geometry, Ellipsoid):
        return geometry.radii
    return (geometry.radius,) if isinstance(geometry, Sphere) else ()
