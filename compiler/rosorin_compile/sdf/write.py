"""The SDF of a robot, as text.

Every frame of the description is in it: what has mass is a ``<link>``, the rest ``<frame attached_to>`` (``bodies``).
Each pose is relative to the frame that the description has it in, so that its numbers are those of the description: a
joint is placed in its parent, the child at the joint, a shape in its own frame.
Rules of the readers: the specification files of libsdformat 12, and what Drake 1.51 refuses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple
from typing import NamedTuple

from rosorin_compile.formats.gazebo_sensors import DISTRIBUTIONS, distribution, sensor_lines
from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Joint,
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
from rosorin_compile.model.simulation import CLASSIC, Entry, GazeboSensor
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, first_of, quoted
from rosorin_compile.source.numbers import NumberFormat, number_format, numbers, vector
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.escaping import escape
from rosorin_compile.source.xml.imu import with_noise

from .content import FOLLOWERS, LEAST, NEWEST, OLDEST, content_of, joint_names, version_of, world_of
from .elements import WORLD, collision_elements, kept, own_elements

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
_FRAME_ID = "frame_id"  # the word of 1.12 for what each Gazebo before it has one of its own
_SHAPES = ("visual", "collision")
_LOOPS = ("connect", "weld")
# Three points that are no line hold two bodies together like a weld (m); one is a ball joint.
_CORNERS = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))
_ROUNDING = 1e-12
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class _Form(NamedTuple):
    """How numbers are printed, the version of the SDF, the boxes of height maps."""

    number: NumberFormat
    version: str
    boxes: str

    def numbers(self, values: Sequence[float]) -> str:
        return numbers(values, self.number)

    def pose(self, pose: Pose, relative_to: str = "") -> str:
        """Return a <pose>; empty for one that moves nothing."""
        seen = attributes(relative_to=relative_to) if relative_to else ""
        if pose == IDENTITY:
            return f"<pose{seen}/>" if relative_to else ""
        return f"<pose{seen}>{vector(pose.xyz, self.number)} {vector(pose.rpy, self.number)}</pose>"


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return the SDF of a robot.

    Options: ``number_format`` (short, exact or six), ``version`` (1.9 to 1.12; default the first with all words),
    ``height_maps`` (the form of their boxes), ``visuals`` (from_collision, where a link has none), ``gazebo`` (false,
    or which Gazebo: harmonic, fortress or classic; by default sensors in the words of SDF alone).
    """
    form = _Form(number_format(output.options), version_of(robot, output), str(output.options.get("height_maps", ROWS)))
    if output.options.get("visuals") == "from_collision":
        from rosorin_compile.model.looks import with_visuals

        robot = with_visuals(robot)
    writer = _Writer(robot, form, output.options.get("gazebo"))
    return "".join(f"{line}\n" for line in writer.lines()), [*writer.diagnostics()]


def _indented(texts: Sequence[str], indent: str) -> list[str]:
    return [indented(text, indent) for text in texts]


def _filled(start: str, lines: Sequence[str], end: str, indent: str) -> list[str]:
    """Return an element with lines in it, without those that are empty."""
    return [f"{indent}{start}", *filter(None, lines), f"{indent}{end}"]


class _Writer:
    """Writes one robot; ``names`` are the names of its joints in the SDF."""

    def __init__(self, robot: Robot, form: _Form, gazebo: object) -> None:
        self.robot, self.form, self.gazebo = robot, form, gazebo
        self.bodies, self.world, self.names = content_of(robot), world_of(robot), joint_names(robot)
        self.shapes = {purpose: self._named(purpose) for purpose in _SHAPES}
        self.kept = kept(robot, self.bodies.carrier, [j.name for j in robot.joints if self.bodies.has_joint(j)])
        self.loops = [one for one in robot.constraints if one.tag in _LOOPS and one.values.get("active") is not False]
        self.open: list[str] = []
        self.unseen: dict[str, list[str]] = {}
        self.sensors: dict[str, list[str]] = {}
        self.carried: dict[str, list[str]] = {}
        for link in robot.links:
            if link.name in self.bodies.carrier:
                self.carried.setdefault(self.bodies.carrier[link.name], []).append(link.name)
        if gazebo is not False:
            frame_id = _FRAME_ID if form.version == NEWEST else DISTRIBUTIONS.get(distribution(gazebo), "")
            self._sensors(frame_id, distribution(gazebo) == CLASSIC)

    def _named(self, purpose: str) -> dict[str, list[tuple[str, Shape]]]:
        """Return the solids of each link, each with a name that is unique on the body."""
        taken: dict[str, set[str]] = {}
        found: dict[str, list[tuple[str, Shape]]] = {}
        for link in self.robot.links:
            names = taken.setdefault(self.bodies.carrier.get(link.name, ""), set())
            solids = [solid for shape in getattr(link, purpose) for solid in shape.solids(self.form.boxes)]
            for index, solid in enumerate(solids if link.name in self.bodies.carrier else (), 1):
                name = solid.name or f"{link.name}_{purpose}_{index}"
                if name in names and solid.name:
                    name = f"{link.name}_{name}"
                while name in names:
                    name += "_"
                names.add(name)
                found.setdefault(link.name, []).append((name, solid))
        return found

    def lines(self) -> Iterator[str]:
        """Yield the lines of the file."""
        robot, root = self.robot, self.robot.root_in_world
        of_drake = ' xmlns:drake="http://drake.mit.edu"' if self.loops and not self.gazebo else ""
        yield '<?xml version="1.0"?>'
        made = f"Generated by rosorin-compile from the description of {comment(robot.name)}; edits here are lost."
        yield f"<!-- {made} -->"
        for text in sorted({one.stand_in for link in robot.links for one in link.collision if one.stand_in}):
            yield f"<!-- STAND-IN: {comment(text)} -->"
        yield f'<sdf version="{self.form.version}"{of_drake}>'
        yield f"  <model{attributes(name=robot.name, canonical_link=self.bodies.canonical)}>"
        if root.placed and not self.world and root.pose != IDENTITY:
            yield f"    {self.form.pose(root.pose)}"
        for name in self.bodies.in_order(robot.link):
            yield from self._place(name)
        for joint in robot.joints:
            if self.bodies.has_joint(joint):
                yield from self._joint(joint)
        yield from self._closed()
        yield from _indented(self.kept.model, "    ")
        yield "  </model>"
        yield "</sdf>"

    def _place(self, name: str) -> list[str]:
        """Return a link, or a frame that is attached to one."""
        above, attached = self.robot.joint_to.get(name), self.bodies.attached.get(name, "")
        if above is None:
            pose = self.form.pose(IDENTITY, MODEL) if attached else ""
        elif self.bodies.has_joint(above):
            pose = self.form.pose(IDENTITY, self.names[above.name])
        else:
            seen = MODEL if above.parent == self.world else above.parent
            pose = self.form.pose(above.origin, "" if seen == attached else seen)
        if attached:
            names = attributes(name=name, attached_to=attached)
            return [f"    <frame{names}>{pose}</frame>" if pose else f"    <frame{names}/>"]
        inertial = self.bodies.inertials[name]
        texts = dict(zip(_MOMENTS, inertial.printed(self.form.number), strict=True))
        moments = "".join(f"<{key}>{texts[key]}</{key}>" for key in sorted(_MOMENTS))
        own_pose = self.form.pose(inertial.pose)
        mass = [f"        <mass>{self.form.number(inertial.mass)}</mass>", f"        <inertia>{moments}</inertia>"]
        lines = [pose and f"      {pose}"]
        lines += _filled("<inertial>", [own_pose and f"        {own_pose}", *mass], "</inertial>", "      ")
        for purpose in _SHAPES:
            for link in self.carried[name]:
                for called, solid in self.shapes[purpose].get(link, ()):
                    lines += self._shape(link, called, solid, purpose)
        lines += [*self.sensors.get(name, ()), *_indented(self.kept.links.get(name, ()), "      ")]
        return _filled(f"<link{attributes(name=name)}>", lines, "</link>", "    ")

    def _shape(self, link: str, name: str, solid: Shape, purpose: str) -> list[str]:
        """Return a visual or a collision of a link."""
        mine, inner = own_elements(solid.urdf_elements, "material", "mesh")
        pose = self.form.pose(solid.origin(), "" if self.bodies.carrier[link] == link else link)
        geometry = f"<geometry>{_geometry(solid, self.form, inner.get('mesh', ()))}</geometry>"
        texts = [element.verbatim for element in mine]
        start = f"<{purpose}{attributes(name=name)}>"
        if purpose == "visual":
            look = self._look(solid, inner.get("material", ()))
            lines = [pose and f"        {pose}", f"        {geometry}", look and f"        <material>{look}</material>"]
            return _filled(start, [*lines, *_indented(texts, "        ")], "</visual>", "      ")
        friction = solid.contact.sliding_friction if solid.contact else None
        said = {} if friction is None else dict.fromkeys(("mu1", "mu2"), self.form.number(friction))
        texts += collision_elements(said | self.kept.collisions.get(link, {}), {element.tag for element in mine})
        if not texts:
            return [f"      {start}{pose}{geometry}</collision>"]
        return _filled(start, [f"        {pose}{geometry}", *_indented(texts, "        ")], "</collision>", "      ")

    def _look(self, visual: Shape, more: Sequence[str]) -> str:
        """Return the contents of a material; ``more`` are those that the description has for SDF alone."""
        rgba, texture = self.robot.colour(visual), self.robot.texture(visual)
        made = ""
        if rgba is not None:
            colour = self.form.numbers(rgba)
            made = "" if any(text.startswith("<ambient") for text in more) else f"<ambient>{colour}</ambient>"
            made += f"<diffuse>{colour}</diffuse>"
        if texture:
            made += f"<pbr><metal><albedo_map>{escape(texture)}</albedo_map></metal></pbr>"
        return made + "".join(more)

    def _joint(self, joint: Joint) -> list[str]:
        """Return a joint with its axis and what the description keeps for it."""
        parent = WORLD if joint.parent == self.world else joint.parent
        mine, inner = own_elements(joint.urdf_elements, "axis", "axis/limit", "axis/dynamics")
        lines = [f"      {self.form.pose(joint.origin, MODEL if parent == WORLD and self.world else parent)}"]
        lines.append(f"      <parent>{escape(parent)}</parent><child>{escape(joint.child)}</child>")
        if not (joint.is_fixed or joint.is_axleless):
            lines += _filled("<axis>", self._axis(joint, inner), "</axis>", "      ")
        texts = [*self.kept.joints.get(joint.name, ()), *(element.verbatim for element in mine)]
        lines += [*self.sensors.get(f"joint {joint.name}", ()), *_indented(texts, "      ")]
        return _filled(f"<joint{attributes(name=self.names[joint.name], type=joint.type)}>", lines, "</joint>", "    ")

    def _axis(self, joint: Joint, more: Mapping[str, Sequence[str]]) -> list[str]:
        number, limit, dynamics, mimic = self.form.number, joint.limit, joint.dynamics, joint.mimic
        keys = ("effort", "velocity") if joint.type == "continuous" else ("lower", "upper", "effort", "velocity")
        limits = [(key, limit.known(key)) for key in keys] if limit else []
        words: list[tuple[str, float | None]] = []
        if dynamics is not None:
            words = [(key, getattr(dynamics, key) or None) for key in ("damping", "friction")]
            if dynamics.stiffness:
                words += [("spring_reference", dynamics.spring_reference), ("spring_stiffness", dynamics.stiffness)]
        lines = [f"        <xyz>{vector(joint.axis, number)}</xyz>"]
        for tag, values in (("limit", limits), ("dynamics", words)):
            texts = [f"<{key}>{number(value)}</{key}>" for key, value in values if value is not None]
            text = "".join([*texts, *more.get(f"axis/{tag}", ())])
            lines.append(text and f"        <{tag}>{text}</{tag}>")
        if mimic is not None:
            text = f"<multiplier>{number(mimic.multiplier)}</multiplier><offset>{number(mimic.offset)}</offset>"
            leader = attributes(joint=self.names[mimic.joint])
            lines.append(f"        <mimic{leader}>{text}<reference>0</reference></mimic>")
        return [*lines, *_indented(more.get("axis", ()), "        ")]

    def _closed(self) -> Iterator[str]:
        """Yield what closes each kinematic loop: a ball or fixed joint for Gazebo, or constraints for Drake.

        Drake 1.51 refuses a file whose joints are no tree, and Gazebo has no word but joints.
        """
        places = self.robot.poses_in_root({})
        taken = {link.name for link in self.robot.links} | set(self.names.values())
        for one in self.loops:
            ends = self._ends(one)
            if ends is None:
                self.open.append(one.name)
                continue
            (first, at_first), (second, _) = ends
            if self.gazebo:
                name = one.name
                while name in taken:
                    name += "_loop"
                taken.add(name)
                names = attributes(name=name, type="ball" if one.tag == "connect" else "fixed")
                lines = [f"      {self.form.pose(Pose(at_first.xyz, IDENTITY.rpy), first)}"]
                lines.append(f"      <parent>{escape(first)}</parent><child>{escape(second)}</child>")
                yield from _filled(f"<joint{names}>", lines, "</joint>", "    ")
                continue
            point, word = places[first].then(at_first), "drake:ball_constraint"
            for number, corner in enumerate(_CORNERS if one.tag == "weld" else _CORNERS[:1]):
                lines = []
                for letter, end, link in (("A", "p_AP", first), ("B", "p_BQ", second)):
                    carrier = self.bodies.carrier[link]
                    place = places[carrier].inverse().apply(point.apply(corner))
                    numbers = vector([0.0 if abs(value) < _ROUNDING else value for value in place], self.form.number)
                    lines.append(f"      <{word}_body_{letter}>{escape(carrier)}</{word}_body_{letter}>")
                    lines.append(f"      <{word}_{end}>{numbers}</{word}_{end}>")
                names = attributes(name=f"{one.name}_{number}" if number else one.name)
                yield from _filled(f"<{word}{names}>", lines, f"</{word}>", "    ")

    def _ends(self, one: Entry) -> tuple[tuple[str, Transform], tuple[str, Transform]] | None:
        """Return the two links of a constraint, each with its point; None unless both are links of the SDF.

        MuJoCo holds together what coincides where all joints are at zero.
        """
        if "relpose" in one.values:
            return None
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

    def _sensors(self, frame_id: str, classic: bool) -> None:
        """Write the sensors of Gazebo by the link or joint that they are in; ``classic``: by its names."""
        for sensor in self.robot.sensors:
            for one in sensor.gazebo:
                where = self._where(sensor, one)
                if where:
                    names = [name for name, _ in self.shapes["collision"].get(one.feels, ())]
                    link = one.feels or one.link
                    seen = "" if one.at_joint or self.bodies.carrier[link] == link else link
                    pose = self.form.pose(IDENTITY if one.at_joint or one.feels else one.pose, seen)
                    said = one.in_classic() if classic else one
                    lines = sensor_lines(said, frame_id, self.form.number, "      ", pose, names)
                    self.sensors.setdefault(where, []).append(with_noise("\n".join(lines)))

    def _where(self, sensor: Sensor, one: GazeboSensor) -> str:
        """Return the link, or "joint NAME", that a sensor is in; empty where it cannot be, which is reported."""
        if one.at_joint:
            if self.bodies.has_joint(self.robot.joint[one.link]):
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
        """Yield what the SDF does not contain, or contains in another form."""

        def several(names: Sequence[str], what: str, verbs: tuple[str, str]) -> str:
            one = len(names) == 1
            return f"{what if one else f'{what}s'} {quoted(names, 3)} {verbs[0] if one else verbs[1]}"

        def lost(message: str, help: str = "", rule: str = "sdf-cannot-say") -> Diagnostic:
            return Diagnostic(rule, WARNING, message, help=help)

        weightless, robot, version = self.bodies.weightless, self.robot, self.form.version
        if weightless:
            message = f"{several(weightless, 'link', ('has', 'have'))} no mass, nor what is fixed there:"
            message += f" {LEAST.mass:g} kg in the SDF, whose readers would take 1 kg"
            help = "give it an inertial" if len(weightless) == 1 else "give them inertials"
            yield lost(message, help, "sdf-without-mass")
        planar = [joint.name for joint in robot.joints if joint.type == "planar"]
        if planar:
            what = f"{counted(len(planar), 'joint')} ({first_of(planar, 3)})"
            what = f'joint "{planar[0]}"' if len(planar) == 1 else what
            message = f"SDF has no planar joint: without {what} the link is free to move every way"
            yield lost(message, "or make it two prismatic joints and a continuous")
        several_axes = [j for j in robot.joints if not j.moves and not j.is_fixed]
        names = [joint.name for joint in several_axes if joint.dynamics and any(astuple(joint.dynamics))]
        if names:
            message = f"SDF has no dynamics of joints that move in several directions: {quoted(names, 3)}"
            yield lost(message, "make each of them several joints, one for each axis")
        for name, other in self.names.items():
            if name != other and self.bodies.has_joint(robot.joint[name]):
                message = f'joint "{name}" is called "{other}" in the SDF, where a link or a frame has that name'
                yield lost(message, "give it another name in the description")
        followers = [joint.name for joint in robot.joints if joint.mimic]
        if followers and version in (OLDEST, "1.10"):
            message = f"SDF {version} has no mimic: Gazebo lets {quoted(followers, 3)} move freely"
            yield lost(message, f'say version: "{FOLLOWERS}"')
        for why, names in self.unseen.items():
            message = f"{several(names, 'sensor', ('is', 'are'))} not seen by Gazebo: {why}"
            yield lost(message, "or leave the sensor out: gazebo: []", "gazebo-cannot-see")
        closed = [one.name for one in self.loops if one.name not in self.open]
        which = several(closed, "constraint", ("is", "are"))
        if self.open:
            message = f"{several(self.open, 'constraint', ('is', 'are'))} not in the SDF"
            yield lost(message, "both ends have to be links of the SDF")
        couplings = [one.name for one in robot.constraints if one.tag not in _LOOPS]
        if couplings:
            message = f"{several(couplings, 'constraint', ('is', 'are'))} not in the SDF"
            yield lost(message, "SDF couples joints by mimic alone")
        if closed and not self.gazebo:
            help = 'write gazebo: "classic" for joints that close it'
            yield lost(f"{which} closed in Drake alone: Drake refuses joints that form a loop", help)
        elif closed and self.gazebo != CLASSIC:
            help = "see github.com/gazebosim/gz-physics/issues/25; Gazebo classic closes it"
            yield lost(f"{which} open in Gazebo {distribution(self.gazebo)}", help)
        if self.kept.left_out:
            message = f"SDF cannot express {first_of(list(self.kept.left_out), 3)}: only readers of URDF know it"
            yield Diagnostic("not-in-format", NOTE, message)


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
