"""The SDF of a robot, as text.

Every frame of the description is in it: what has mass is a ``<link>``, the rest ``<frame attached_to>`` (``bodies``).
Each pose is relative to the frame that the description has it in, so that its numbers are those of the description: a
joint sits in its parent, the child at the joint, a shape in its own frame.
Rules of the readers: the specification files of libsdformat 12, and what Drake 1.51 refuses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from rosorin_compile.formats.gazebo_sensors import DISTRIBUTIONS, distribution, sensor_lines
from rosorin_compile.formats.templating import Templates, attributes, comment
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
    Sensor,
    Shape,
    Sphere,
    Transform,
)
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.shape import ROWS
from rosorin_compile.model.simulated import CLASSIC, GazeboSensor
from rosorin_compile.model.simulator import Entry
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, first_of, quoted
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.escaping import escape
from rosorin_compile.source.xml.imu import with_noise

from .bodies import LEAST, Bodies, bodies_of
from .kept import Kept, at, kept, of_collision, own
from .words import WORLD, world_of

RULES = (
    Rule(
        "sdf-cannot-say",
        "A warning: SDF has no planar joint; before 1.11 it has no mimic; a joint and a link have one name, which is "
        "one too many. A note: what a description has for the reader of URDF alone.",
        "The message says what is written, or what to do.",
        Heading.FORMATS,
    ),
    Rule(
        "sdf-without-mass",
        "A warning: a link that moves has no mass, nor what is fixed to it. SDF would take it for 1 kg, so that the "
        "least that engines take is written.",
        "Give it an `inertial`.",
        Heading.FORMATS,
    ),
)

MODEL = "__model__"
FOLLOWERS = "1.11"  # the first version with a word for mimic
OLDEST, NEWEST = "1.9", "1.12"
_FRAME_ID = "frame_id"  # the word of 1.12 for what each Gazebo before it has one of its own


class _Form(NamedTuple):
    """How the SDF is asked for: how numbers are printed, its version, the boxes of height maps."""

    number: NumberFormat
    version: str
    boxes: str

    def numbers(self, values: Sequence[float]) -> str:
        return numbers(values, self.number)

    def pose(self, pose: Pose, relative_to: str = "") -> str:
        """Return a <pose>; nothing where it says nothing."""
        seen = attributes(relative_to=relative_to) if relative_to else ""
        if pose == IDENTITY:
            return f"<pose{seen}/>" if relative_to else ""
        return f"<pose{seen}>{vector(pose.xyz, self.number)} {vector(pose.rpy, self.number)}</pose>"


def version_of(robot: Robot, output: Output) -> str:
    """Return the version of an output; 1.9 is a number in YAML, and a name all the same."""
    asked = output.options.get("version")
    if asked is not None:
        return "1.10" if asked == 1.1 else str(asked)
    return FOLLOWERS if any(joint.mimic for joint in robot.joints) else OLDEST


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return the SDF of a robot.

    Options: ``number_format`` (short, exact or six), ``version`` (1.9 to 1.12; default the first that says all),
    ``height_maps`` (the form of their boxes), ``visuals`` (from_collision, where a link has none), ``gazebo`` (false,
    or which Gazebo: harmonic, fortress or classic; by default sensors in the words of SDF alone).
    """
    number = number_format(output.options)
    form = _Form(number, version_of(robot, output), str(output.options.get("height_maps", ROWS)))
    if output.options.get("visuals") == "from_collision":
        from rosorin_compile.model.looks import with_visuals

        robot = with_visuals(robot)
    writer = _Writer(robot, form, output.options.get("gazebo"))
    values = {
        "robot": robot,
        "comment": comment,
        "version": form.version,
        "names": attributes(name=robot.name, canonical_link=writer.bodies.canonical),
        "pose": writer.stands(),
        "stand_ins": sorted({one.stand_in for link in robot.links for one in link.collision if one.stand_in}),
        "places": [writer.place(robot.link[name]) for name in writer.bodies.in_order(robot.link)],
        "joints": [writer.joint(joint) for joint in robot.joints if writer.bodies.says(joint)],
        "elements": [*writer.loops(), *at(writer.kept.model, "    ")],
        "drake": bool(writer.loop_constraints) and not output.options.get("gazebo"),
    }
    return templates.own("sdf/robot.sdf.jinja", values), [*writer.diagnostics()]


class _Writer:
    """Writes one robot; ``names`` are what its joints are called."""

    def __init__(self, robot: Robot, form: _Form, gazebo: object) -> None:
        self.robot = robot
        self.form = form
        self.bodies: Bodies = bodies_of(robot)
        self.world = world_of(robot)
        self.names = joint_names(robot)
        self.shapes = {purpose: self._named(purpose) for purpose in _SHAPES}
        self.kept: Kept = kept(robot, self.bodies.carrier, [j.name for j in robot.joints if self.bodies.says(j)])
        self.gazebo = gazebo
        self.open: list[str] = []
        self.unseen: dict[str, list[str]] = {}
        self.sensors: dict[str, list[str]] = {}
        if gazebo is not False:
            asked = distribution(gazebo)
            frame_id = _FRAME_ID if form.version == NEWEST else DISTRIBUTIONS.get(asked, "")
            self._sensors(frame_id, asked == CLASSIC)

    def _named(self, purpose: str) -> dict[str, list[tuple[str, Shape]]]:
        """Return the solids of each link, every one with a name that no other on the same body has."""
        taken: dict[str, set[str]] = {}
        found: dict[str, list[tuple[str, Shape]]] = {}
        for link in self.robot.links:
            carrier = self.bodies.carrier.get(link.name)
            if carrier is None:
                continue
            names = taken.setdefault(carrier, set())
            solids = [solid for shape in getattr(link, purpose) for solid in shape.solids(self.form.boxes)]
            for index, solid in enumerate(solids, 1):
                name = solid.name or f"{link.name}_{purpose}_{index}"
                if name in names and solid.name:
                    name = f"{link.name}_{name}"
                while name in names:
                    name += "_"
                names.add(name)
                found.setdefault(link.name, []).append((name, solid))
        return found

    @cached_property
    def carried(self) -> Mapping[str, Sequence[str]]:
        """The links that each link of the SDF is made of, itself among them, in the order of the description."""
        found: dict[str, list[str]] = {}
        for link in self.robot.links:
            if link.name in self.bodies.carrier:
                found.setdefault(self.bodies.carrier[link.name], []).append(link.name)
        return found

    def stands(self) -> str:
        """Return the pose of the model: where the root is in the world, if the description says so."""
        root = self.robot.root_in_world
        return self.form.pose(root.pose) if root.placed and not self.world else ""

    def place(self, link: Link) -> tuple[Any, ...]:
        """Return a link or a frame: its attributes, its pose, whether it is a frame, and what is in it."""
        name, bodies = link.name, self.bodies
        above = self.robot.joint_to.get(name)
        attached = bodies.attached.get(name, "")
        if above is None:
            pose = self.form.pose(IDENTITY, MODEL) if attached else ""
        elif bodies.says(above):
            pose = self.form.pose(IDENTITY, self.names[above.name])
        else:
            seen = MODEL if above.parent == self.world else above.parent
            pose = self.form.pose(above.origin, "" if seen == attached else seen)
        if attached:
            return attributes(name=name, attached_to=attached), pose, True, [], [], [], []
        shapes = (
            [self._shape(one, *solid, p) for one in self.carried[name] for solid in self.shapes[p].get(one, ())]
            for p in _SHAPES
        )
        kept = [*self.sensors.get(name, ()), *at(self.kept.links.get(name, ()), "      ")]
        return attributes(name=name), pose, False, self._inertial(bodies.inertials[name]), *shapes, kept

    def _inertial(self, inertial: Inertial) -> list[Any]:
        """Return pose, mass and moments of an inertial, as a list of one."""
        texts = dict(zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), inertial.printed(self.form.number), strict=True))
        moments = [(key, texts[key]) for key in _MOMENTS]
        return [(self.form.pose(inertial.pose), self.form.number(inertial.mass), moments)]

    def _shape(self, link: str, name: str, solid: Shape, purpose: str) -> tuple[Any, ...]:
        """Return a shape: its attributes, pose, geometry, and how it looks."""
        seen = "" if self.bodies.carrier[link] == link else link
        kept = own(solid.urdf_elements, "material", "mesh")
        look = self._look(solid, kept.inner.get("material", ())) if purpose == "visual" else ""
        geometry = _geometry(solid, self.form, kept.inner.get("mesh", ()))
        texts = [element.verbatim for element in kept.elements]
        if purpose == "collision":
            friction = solid.contact.sliding_friction if solid.contact else None
            own_friction = {} if friction is None else dict.fromkeys(("mu1", "mu2"), self.form.number(friction))
            said = {**own_friction, **self.kept.collisions.get(link, {})}
            texts += of_collision(said, {element.tag for element in kept.elements})
        more = at(texts, "        ")
        return attributes(name=name), self.form.pose(solid.origin(), seen), geometry, look, more

    def _look(self, visual: Shape, kept: Sequence[str]) -> str:
        """Return the elements of a material; ``kept`` are those that the description has for SDF alone."""
        rgba, texture = self.robot.colour(visual), self.robot.texture(visual)
        made = []
        if rgba is not None:
            colour = self.form.numbers(rgba)
            if not any(text.startswith("<ambient") for text in kept):
                made.append(f"<ambient>{colour}</ambient>")
            made.append(f"<diffuse>{colour}</diffuse>")
        if texture:
            made.append(f"<pbr><metal><albedo_map>{escape(texture)}</albedo_map></metal></pbr>")
        return "".join([*made, *kept])

    def joint(self, joint: Joint) -> tuple[Any, ...]:
        """Return a joint: its attributes, pose, ends, what is said of its axis, and what else is in it."""
        world = joint.parent == self.world
        pose = self.form.pose(joint.origin, MODEL if world else joint.parent)
        ends = WORLD if world else joint.parent, joint.child
        mine = own(joint.urdf_elements, "axis", "axis/limit", "axis/dynamics")
        texts = [*self.kept.joints.get(joint.name, ()), *(element.verbatim for element in mine.elements)]
        kept = [*self.sensors.get(f"joint {joint.name}", ()), *at(texts, "      ")]
        axis = [] if joint.is_fixed or joint.is_axleless else [self._axis(joint, mine.inner)]
        return attributes(name=self.names[joint.name], type=joint.type), pose, *ends, axis, kept

    def _axis(self, joint: Joint, kept: Mapping[str, Sequence[str]]) -> tuple[Any, ...]:
        """Return what is said of an axis: direction, limit, dynamics, what it follows, and what is kept."""
        number, limit, dynamics, mimic = self.form.number, joint.limit, joint.dynamics, joint.mimic
        keys = ("effort", "velocity") if joint.type == "continuous" else ("lower", "upper", "effort", "velocity")
        known = [(key, limit.known(key)) for key in keys] if limit else []
        limits = [(key, number(value)) for key, value in known if value is not None]
        words: list[tuple[str, float]] = []
        if dynamics is not None:
            words = [(key, value) for key in ("damping", "friction") if (value := getattr(dynamics, key))]
            if dynamics.stiffness:
                words += [("spring_reference", dynamics.spring_reference), ("spring_stiffness", dynamics.stiffness)]
        follows = []
        if mimic is not None:
            leader = attributes(joint=self.names[mimic.joint])
            follows = [(leader, number(mimic.multiplier), number(mimic.offset))]
        dynamics_of = _pairs([(key, number(value)) for key, value in words], kept.get("axis/dynamics", ()))
        limits_of = _pairs(limits, kept.get("axis/limit", ()))
        return vector(joint.axis, number), limits_of, dynamics_of, follows, at(kept.get("axis", ()), "        ")

    @property
    def loop_constraints(self) -> list[Entry]:
        """The active constraints that hold two links together."""
        return [one for one in self.robot.constraints if one.tag in _LOOPS and one.values.get("active") is not False]

    def loops(self) -> Iterator[str]:
        """Yield what closes each kinematic loop: a ball or fixed joint for Gazebo, or constraints for Drake.

        Drake 1.51 refuses a file whose joints are no tree, and Gazebo has no word but joints.
        """
        places = self.robot.poses_in_root({})
        for one in self.loop_constraints:
            ends = self._ends(one)
            if ends is None:
                self.open.append(one.name)
                continue
            (first, at_first), (second, _) = ends
            if self.gazebo:
                kind = "ball" if one.tag == "connect" else "fixed"
                yield f"    <joint{attributes(name=self._free_name(one.name), type=kind)}>"
                yield f"      {self.form.pose(Pose(at_first.xyz, IDENTITY.rpy), first)}"
                yield f"      <parent>{escape(first)}</parent><child>{escape(second)}</child>"
                yield "    </joint>"
                continue
            carriers = [self.bodies.carrier[name] for name in (first, second)]
            point = places[first].then(at_first)
            for number, corner in enumerate(_CORNERS if one.tag == "weld" else _CORNERS[:1]):
                suffix = f"_{number}" if number else ""
                yield f"    <drake:ball_constraint{attributes(name=f'{one.name}{suffix}')}>"
                for letter, end, carrier in zip("AB", ("p_AP", "p_BQ"), carriers, strict=True):
                    place = places[carrier].inverse().apply(point.apply(corner))
                    numbers = vector([0.0 if abs(value) < _ROUNDING else value for value in place], self.form.number)
                    word = "drake:ball_constraint"
                    yield f"      <{word}_body_{letter}>{escape(carrier)}</{word}_body_{letter}>"
                    yield f"      <{word}_{end}>{numbers}</{word}_{end}>"
                yield "    </drake:ball_constraint>"

    def _ends(self, one: Entry) -> tuple[tuple[str, Transform], tuple[str, Transform]] | None:
        """Return the two links of a constraint, each with its point; None unless both are links of the SDF.

        MuJoCo holds together what coincides where all joints are at zero.
        """
        found: list[tuple[str, Transform]] = []
        for number in (1, 2):
            name = str(one.values.get(f"body{number}", one.values.get(f"site{number}", "")))
            place = Transform()
            for link in self.robot.links:
                for mark in link.marked:
                    if "site1" in one.values and (mark.tag, mark.name) == ("site", name):
                        name, place = link.name, mark.pose.transform()
            if name not in self.bodies.carrier:
                return None
            found.append((name, place))
        anchor = one.values.get("anchor")
        if isinstance(anchor, tuple):
            x, y, z = (float(value) for value in anchor)
            found[0] = found[0][0], Transform(xyz=(x, y, z))
        return found[0], found[1]

    def _free_name(self, name: str) -> str:
        taken = {link.name for link in self.robot.links} | set(self.names.values())
        while name in taken:
            name += "_loop"
        return name

    def _sensors(self, frame_id: str, classic: bool) -> None:
        """Make what Gazebo has of the sensors, by the link or joint that they stand in; ``classic``: by its names."""
        for sensor in self.robot.sensors:
            for one in sensor.gazebo:
                where = self._where(sensor, one)
                if not where:
                    continue
                names = [name for name, _ in self.shapes["collision"].get(one.feels, ())]
                link = one.feels or one.link
                seen = "" if one.at_joint or self.bodies.carrier[link] == link else link
                pose = self.form.pose(IDENTITY if one.at_joint or one.feels else one.pose, seen)
                said = one.in_classic() if classic else one
                lines = sensor_lines(said, frame_id, self.form.number, "      ", pose, names)
                self.sensors.setdefault(where, []).append(with_noise("\n".join(lines)))

    def _where(self, sensor: Sensor, one: GazeboSensor) -> str:
        """Return the link, or "joint NAME", that a sensor stands in; empty where it cannot, after telling."""
        why = ""
        if one.at_joint:
            if self.bodies.says(self.robot.joint[one.link]):
                return f"joint {one.link}"
            why = f'joint "{one.link}" holds nothing that has mass'
        elif one.feels and not self.shapes["collision"].get(one.feels):
            why = f'link "{one.feels}" has no shape that could feel'
        elif (one.feels or one.link) in self.bodies.carrier:
            return self.bodies.carrier[one.feels or one.link]
        else:
            why = f'"{one.link}" is the world'
        self.unseen.setdefault(why, []).append(sensor.name)
        return ""

    def diagnostics(self) -> Iterator[Diagnostic]:
        """Yield what the SDF cannot say, or says otherwise."""
        weightless = self.bodies.weightless
        if weightless:
            which = f"{'link' if len(weightless) == 1 else 'links'} {quoted(weightless, 3)}"
            message = f"{which} {'has' if len(weightless) == 1 else 'have'} no mass, nor what is fixed there:"
            message += f" {LEAST.mass:g} kg in the SDF, whose readers would take 1 kg"
            help = "give it an inertial" if len(weightless) == 1 else "give them inertials"
            yield Diagnostic("sdf-without-mass", WARNING, message, help=help)
        yield from self._joints_told()
        for why, names in self.unseen.items():
            which = f"{'sensor' if len(names) == 1 else 'sensors'} {quoted(names, 3)}"
            message = f"{which} {'is' if len(names) == 1 else 'are'} not seen by Gazebo: {why}"
            yield Diagnostic("gazebo-cannot-see", WARNING, message, help="or leave the sensor out: gazebo: []")
        yield from self._loops_told()
        if self.kept.left_out:
            message = f"not in the SDF, for the reader of URDF alone knows it: {first_of(list(self.kept.left_out), 3)}"
            yield Diagnostic("sdf-cannot-say", NOTE, message)

    def _loops_told(self) -> Iterator[Diagnostic]:
        """Yield a warning for loops that one of the two readers does not close."""
        names = [one.name for one in self.loop_constraints if one.name not in self.open]
        if self.open:
            message = f"{'constraint' if len(self.open) == 1 else 'constraints'} {quoted(self.open, 3)} left open"
            yield Diagnostic("sdf-cannot-say", WARNING, f"{message} in the SDF: both ends have to be links of it")
        if not names:
            return
        verb = "is" if len(names) == 1 else "are"
        which = f"the {'loop' if len(names) == 1 else 'loops'} of {'constraint' if len(names) == 1 else 'constraints'}"
        if not self.gazebo:
            message = f"{which} {quoted(names, 3)} {verb} closed in Drake alone: Drake refuses joints that form a loop"
            yield Diagnostic(
                "sdf-cannot-say", WARNING, message, help='write gazebo: "classic" for joints that close it'
            )
        elif self.gazebo != CLASSIC:
            message = f"{which} {quoted(names, 3)} {verb} open in Gazebo {distribution(self.gazebo)}"
            help = "see github.com/gazebosim/gz-physics/issues/25; Gazebo classic closes it"
            yield Diagnostic("sdf-cannot-say", WARNING, message, help=help)

    def _joints_told(self) -> Iterator[Diagnostic]:
        planar = [joint.name for joint in self.robot.joints if joint.type == "planar"]
        if planar:
            what = (
                f'joint "{planar[0]}"'
                if len(planar) == 1
                else f"{counted(len(planar), 'joint')} ({first_of(planar, 3)})"
            )
            message = f"SDF has no planar joint: without {what} the link is free to move every way"
            yield Diagnostic(
                "sdf-cannot-say", WARNING, message, help="or make it two prismatic joints and a continuous"
            )
        for name, other in self.names.items():
            if name != other and self.bodies.says(self.robot.joint[name]):
                message = f'joint "{name}" is called "{other}" in the SDF, where a link or a frame has that name'
                yield Diagnostic("sdf-cannot-say", WARNING, message, help="give it another name in the description")
        followers = [joint.name for joint in self.robot.joints if joint.mimic]
        if followers and self.form.version in (OLDEST, "1.10"):
            message = f"SDF {self.form.version} has no mimic: Gazebo lets {quoted(followers, 3)} move freely"
            yield Diagnostic("sdf-cannot-say", WARNING, message, help=f'say version: "{FOLLOWERS}"')


_SHAPES = ("visual", "collision")
_LOOPS = ("connect", "weld")
# Three points that are no line hold two bodies together like a weld (m); one is a ball joint.
_CORNERS = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))
_ROUNDING = 1e-12
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def joint_names(robot: Robot) -> Mapping[str, str]:
    """Return what each joint is called: links, frames and joints of an SDF share their names."""
    taken = {link.name for link in robot.links} | {joint.name for joint in robot.joints}
    links = {link.name for link in robot.links}
    names = {}
    for joint in robot.joints:
        name = joint.name
        while name in links or (name != joint.name and name in taken):
            name += "_joint"
        taken.add(name)
        names[joint.name] = name
    return names


def _pairs(pairs: Sequence[tuple[str, str]], kept: Sequence[str]) -> str:
    """Return elements by name and number, and those that are kept."""
    return "".join([*(f"<{key}>{number}</{key}>" for key, number in pairs), *kept])


def _geometry(solid: Shape, form: _Form, kept: Sequence[str] = ()) -> str:
    """Return the element of a geometry; ``kept`` stands in that of a mesh. Raises TypeError if it is no solid."""
    shape, number = solid.geometry, form.number
    if isinstance(shape, Box):
        return f"<box><size>{form.numbers(shape.size)}</size></box>"
    if isinstance(shape, (Cylinder, Capsule)):
        tag = "cylinder" if isinstance(shape, Cylinder) else "capsule"
        return f"<{tag}><radius>{number(shape.radius)}</radius><length>{number(shape.length)}</length></{tag}>"
    if isinstance(shape, Sphere):
        return f"<sphere><radius>{number(shape.radius)}</radius></sphere>"
    if isinstance(shape, Ellipsoid):
        return f"<ellipsoid><radii>{form.numbers(shape.radii)}</radii></ellipsoid>"
    if isinstance(shape, Mesh):
        scale = "" if shape.scale == (1.0, 1.0, 1.0) else f"<scale>{form.numbers(shape.scale)}</scale>"
        return f"<mesh><uri>{escape(shape.file)}</uri>{scale}{''.join(kept)}</mesh>"
    raise TypeError(f"{type(shape).__name__} is not a solid")
