"""Write the SDF of a robot.

The SDF has all frames: links with mass become a ``<link>``, all others a ``<frame attached_to>`` (see ``content``).
Poses have the numbers of the description: a joint is posed relative to its parent, the child relative to that joint,
and a shape relative to its link. Tested with libsdformat 12 and Drake 1.51.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, replace

from markupsafe import escape

from rosorin_compile.formats.gazebo import DISTRIBUTIONS, distribution, drive_blocks, sensor_lines, with_noise
from rosorin_compile.formats.templating import Templates, attributes, comment
from rosorin_compile.model import Joint, Mesh, Output, Pose, Robot, Sensor, Shape, Transform
from rosorin_compile.model.colours import with_visuals
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.model.shape import ROWS
from rosorin_compile.model.simulation import CLASSIC, Entry, GazeboSensor
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of, quote
from rosorin_compile.source.numbers import number_format, numbers, vector
from rosorin_compile.source.wording import plural
from rosorin_compile.source.xml.elements import indented

from . import content as contents
from .content import FOLLOWERS, LEAST, NEWEST, OLDEST, SOLIDS, WORLD, collision_elements, own_elements

MODEL = "__model__"
_FRAME_ID = "frame_id"  # tag for the frame of sensor messages in SDF 1.12; for older versions, it depends on Gazebo
_LOOPS = ("connect", "weld")
# Points (m) of Drake's ball constraints. Three that are not collinear act like a weld, one acts like a ball joint.
_CORNERS = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0))
_NAME, _COLLISION = re.compile(r'name="([^"]*)'), re.compile(r"<collision>\s*([^<]+?)\s*</collision>")
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:  # noqa: ARG001
    """Return (SDF of a robot, diagnostics about properties that SDF cannot express).

    Options: ``number_format`` (short, exact or six), ``version`` (1.9 to 1.12, by default the oldest that suffices),
    ``height_maps`` (how to split them into boxes), ``visuals`` (from_collision: draw links without visuals),
    ``gazebo`` (false, harmonic, fortress or classic; by default, sensors have only standard SDF elements).
    """
    writer = _Writer(with_visuals(robot) if output.options.get("visuals") == "from_collision" else robot, output)
    return "".join(f"{line}\n" for line in writer.lines()), writer.diagnostics()


def _element(start: str, lines: Iterable[str], indent: str) -> list[str]:
    return [f"{indent}<{start}>", *filter(None, lines), f"{indent}</{start.split(' ')[0]}>"]


class _Writer:
    def __init__(self, robot: Robot, output: Output) -> None:
        self.robot, self.gazebo = robot, output.options.get("gazebo")
        self.number, self.version = number_format(output.options), contents.version_of(robot, output)
        self.boxes = str(output.options.get("height_maps", ROWS))
        self.content, self.names = contents.content_of(robot), contents.joint_names(robot)
        self.world = contents.world_of(robot)
        carrier = self.content.carrier
        self.carried: dict[str, list[str]] = {}  # links whose shapes a body of the SDF has
        for link in robot.links:
            self.carried.setdefault(carrier.get(link.name, ""), []).append(link.name)
        self.shapes = {purpose: self._named(purpose) for purpose in ("visual", "collision")}
        self.joints = {joint.name: self.names[joint.name] for joint in robot.joints if self.content.has_joint(joint)}
        others = [text for text in robot.urdf_elements if "<ros2_control" not in text]  # SDF lacks ros2_control
        gazebo = distribution(self.gazebo)
        drives, self.idle = drive_blocks(robot, self.joints, "sdf-cannot-say", gazebo, self.number, others)
        driven = replace(robot, urdf_elements=(*robot.urdf_elements, *drives))
        self.kept = contents.sort_elements(driven, carrier, self.joints)
        self.loops = [one for one in robot.constraints if one.tag in _LOOPS and one.values.get("active") is not False]
        self.open: list[str] = []  # names of kinematic loops that are not written
        self.unseen: dict[str, list[str]] = {}  # names of sensors that are not written, by reason
        self.sensors: dict[str, list[str]] = {}  # XML of sensors by link or by "joint NAME"
        for sensor in robot.sensors if self.gazebo is not False else ():
            for one in sensor.gazebo:
                self._sensor(sensor, one)

    def _named(self, purpose: str) -> dict[str, list[tuple[str, Shape]]]:
        taken, found = set[tuple[str, str]](), dict[str, list[tuple[str, Shape]]]()
        for link in (link for link in self.robot.links if link.name in self.content.carrier):
            body = self.content.carrier[link.name]
            solids = [solid for shape in getattr(link, purpose) for solid in shape.solids(self.boxes)]
            for index, solid in enumerate(solids, 1):
                name = solid.name or f"{link.name}_{purpose}_{index}"
                name = f"{link.name}_{name}" if (body, name) in taken and solid.name else name
                while (body, name) in taken:
                    name += "_"
                taken.add((body, name))
                found.setdefault(link.name, []).append((name, solid))
        return found

    def pose(self, pose: Pose, relative_to: str = "") -> str:
        base = attributes(relative_to=relative_to) if relative_to else ""
        if pose == IDENTITY:
            return f"<pose{base}/>" if relative_to else ""
        return f"<pose{base}>{vector(pose.xyz, self.number)} {vector(pose.rpy, self.number)}</pose>"

    def lines(self) -> Iterator[str]:
        robot, root = self.robot, self.robot.root_in_world
        of_drake = ' xmlns:drake="http://drake.mit.edu"' if self.loops and not self.gazebo else ""
        yield '<?xml version="1.0"?>'
        made = f"Generated by rosorin-compile from the description of {comment(robot.name)}; edits here are lost."
        yield f"<!-- {made} -->"
        for text in sorted({one.stand_in for link in robot.links for one in link.collision if one.stand_in}):
            yield f"<!-- STAND-IN: {comment(text)} -->"
        yield f'<sdf version="{self.version}"{of_drake}>'
        yield f"  <model{attributes(name=robot.name, canonical_link=self.content.canonical)}>"
        if root.placed and not self.world and root.pose != IDENTITY:
            yield f"    {self.pose(root.pose)}"
        for name in self.content.in_order(robot.link):
            yield from self._link(name)
        for joint in (joint for joint in robot.joints if self.content.has_joint(joint)):
            yield from self._joint(joint)
        yield from self._closed()
        yield from indented(self.kept.model, "    ")
        yield "  </model>"
        yield "</sdf>"

    def _link(self, name: str) -> list[str]:
        above, attached = self.robot.joint_to.get(name), self.content.attached.get(name, "")
        if above is None:
            pose = self.pose(IDENTITY, MODEL) if attached else ""
        elif self.content.has_joint(above):
            pose = self.pose(IDENTITY, self.names[above.name])
        else:
            base = MODEL if above.parent == self.world else above.parent
            pose = self.pose(above.origin, "" if base == attached else base)
        if attached:
            names = attributes(name=name, attached_to=attached)
            return [f"    <frame{names}>{pose}</frame>" if pose else f"    <frame{names}/>"]
        inertial = self.content.inertials[name]
        texts = dict(zip(_MOMENTS, inertial.printed_inertia(self.number), strict=True))
        moments = "".join(f"<{key}>{texts[key]}</{key}>" for key in sorted(_MOMENTS))
        centre = self.pose(inertial.pose)
        mass = [f"        <mass>{self.number(inertial.mass)}</mass>", f"        <inertia>{moments}</inertia>"]
        lines = [pose and f"      {pose}"]
        lines += _element("inertial", [centre and f"        {centre}", *mass], "      ")
        for purpose, shapes in self.shapes.items():
            for link in self.carried[name]:
                for called, solid in shapes.get(link, ()):
                    lines += self._shape(link, called, solid, purpose)
        lines += [*self.sensors.get(name, ()), *indented(self.kept.links.get(name, ()), "      ")]
        return _element(f"link{attributes(name=name)}", lines, "    ")

    def _shape(self, link: str, name: str, solid: Shape, purpose: str) -> list[str]:
        own, inner = own_elements(solid.urdf_elements, "material", "mesh")
        pose = self.pose(solid.origin(), "" if self.content.carrier[link] == link else link)
        geometry = f"<geometry>{self._geometry(solid, inner.get('mesh', ()))}</geometry>"
        texts, start = [element.verbatim for element in own], f"{purpose}{attributes(name=name)}"
        if purpose == "visual":
            look = self._look(solid, inner.get("material", ()))
            lines = [pose and f"        {pose}", f"        {geometry}", look and f"        <material>{look}</material>"]
            return _element(start, [*lines, *indented(texts, "        ")], "      ")
        friction = solid.contact.sliding_friction if solid.contact else None
        surface = {} if friction is None else dict.fromkeys(("mu1", "mu2"), self.number(friction))
        texts += collision_elements(surface | self.kept.collisions.get(link, {}), {element.tag for element in own})
        if not texts:
            return [f"      <{start}>{pose}{geometry}</collision>"]
        return _element(start, [f"        {pose}{geometry}", *indented(texts, "        ")], "      ")

    def _geometry(self, solid: Shape, kept: Sequence[str]) -> str:
        shape, number, tag = solid.geometry, self.number, type(solid.geometry).__name__.lower()
        sizes = {key: getattr(shape, key) for key in SOLIDS[tag]}
        texts = {key: numbers(size, number) if isinstance(size, tuple) else number(size) for key, size in sizes.items()}
        if isinstance(shape, Mesh):
            texts = {"uri": escape(shape.file), **({} if shape.scale == (1.0, 1.0, 1.0) else texts)}
        inner = "".join(f"<{key}>{text}</{key}>" for key, text in texts.items())
        return f"<{tag}>{inner}{''.join(kept)}</{tag}>"

    def _look(self, visual: Shape, more: Sequence[str]) -> str:
        rgba, texture, parts = self.robot.colour(visual), self.robot.texture(visual), list[str]()
        if rgba is not None:
            is_own = any(text.startswith("<ambient") for text in more)
            parts = [f"<{key}>{numbers(rgba, self.number)}</{key}>" for key in ("ambient", "diffuse")[is_own:]]
        parts += [f"<pbr><metal><albedo_map>{escape(texture)}</albedo_map></metal></pbr>"] if texture else []
        return "".join([*parts, *more])

    def _joint(self, joint: Joint) -> list[str]:
        own, inner = own_elements(joint.urdf_elements, "axis", "axis/limit", "axis/dynamics")
        lines = self._ends(joint.origin, joint.parent, joint.child)
        if not (joint.is_fixed or joint.is_axleless):
            lines += _element("axis", self._axis(joint, inner), "      ")
        texts = [*self.kept.joints.get(joint.name, ()), *(element.verbatim for element in own)]
        lines += [*self.sensors.get(f"joint {joint.name}", ()), *indented(texts, "      ")]
        return _element(f"joint{attributes(name=self.names[joint.name], type=joint.type)}", lines, "    ")

    def _ends(self, pose: Pose, parent: str, child: str) -> list[str]:
        base, parent = (MODEL, WORLD) if parent == self.world else (parent, parent)
        ends = f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>"
        return [f"      {self.pose(pose, base)}", f"      {ends}"]

    def _axis(self, joint: Joint, more: Mapping[str, Sequence[str]]) -> list[str]:
        number, limit, dynamics, mimic = self.number, joint.limit, joint.dynamics, joint.mimic
        keys = ("effort", "velocity") if joint.type == "continuous" else ("lower", "upper", "effort", "velocity")
        limits = [(key, limit.known_value(key)) for key in keys] if limit else []
        motion: list[tuple[str, float | None]] = []
        if dynamics is not None:
            motion = [(key, getattr(dynamics, key) or None) for key in ("damping", "friction")]
            if dynamics.stiffness:
                motion += [("spring_reference", dynamics.spring_reference), ("spring_stiffness", dynamics.stiffness)]
        lines = [f"        <xyz>{vector(joint.axis, number)}</xyz>"]
        for tag, values in (("limit", limits), ("dynamics", motion)):
            texts = [f"<{key}>{number(value)}</{key}>" for key, value in values if value is not None]
            text = "".join([*texts, *more.get(f"axis/{tag}", ())])
            lines.append(text and f"        <{tag}>{text}</{tag}>")
        if mimic is not None:
            text = f"<multiplier>{number(mimic.multiplier)}</multiplier><offset>{number(mimic.offset)}</offset>"
            leader = attributes(joint=self.names[mimic.joint])
            lines.append(f"        <mimic{leader}>{text}<reference>0</reference></mimic>")
        return [*lines, *indented(more.get("axis", ()), "        ")]

    def _closed(self) -> Iterator[str]:
        """Yield a ball or fixed joint for each kinematic loop, or constraints for Drake, which rejects such joints."""
        places = self.robot.poses_in_root({})
        taken = {link.name for link in self.robot.links} | set(self.names.values())
        for loop in self.loops:
            if (ends := self._loop_ends(loop)) is None:
                self.open.append(loop.name)
                continue
            first, second, at = ends
            name = loop.name
            if self.gazebo:
                while name in taken:
                    name += "_loop"
                taken.add(name)
                kind = "ball" if loop.tag == "connect" else "fixed"
                lines = self._ends(Pose(at.xyz), first, second)
                yield from _element(f"joint{attributes(name=name, type=kind)}", lines, "    ")
                continue
            point, word = places[first].then(at), "drake:ball_constraint"
            for number, corner in enumerate(_CORNERS if loop.tag == "weld" else _CORNERS[:1]):
                lines = []
                for letter, end, link in (("A", "p_AP", first), ("B", "p_BQ", second)):
                    carrier = self.content.carrier[link]
                    xyz = places[carrier].inverse().apply(point.apply(corner))
                    text = vector([0.0 if abs(value) < 1e-12 else value for value in xyz], self.number)
                    lines.append(f"      <{word}_body_{letter}>{escape(carrier)}</{word}_body_{letter}>")
                    lines.append(f"      <{word}_{end}>{text}</{word}_{end}>")
                yield from _element(f"{word}{attributes(name=f'{name}_{number}' if number else name)}", lines, "    ")

    def _loop_ends(self, loop: Entry) -> tuple[str, str, Transform] | None:
        """Return (link, link, pose of a constraint in the first link), or None if SDF cannot express it."""
        if "relpose" in loop.values:
            return None
        marks = [(link.name, mark) for link in self.robot.links for mark in link.marked if mark.tag == "site"]
        sites, values = {mark.name: (link, mark.pose.transform()) for link, mark in marks}, loop.values
        first, second, at = str(values.get("body1", "")), str(values.get("body2", "")), Transform()
        if "site1" in values:
            (first, at), (second, _) = (sites.get(str(values.get(f"site{end}")), ("", at)) for end in (1, 2))
        anchor = values.get("anchor")
        if isinstance(anchor, tuple):
            x, y, z = (float(value) for value in anchor)
            at = Transform(xyz=(x, y, z))
        return (first, second, at) if {first, second} <= self.content.carrier.keys() else None

    def _sensor(self, sensor: Sensor, one: GazeboSensor) -> None:
        kind, link, why = distribution(self.gazebo), one.feels or one.link, ""
        frame_id = _FRAME_ID if self.version == NEWEST else DISTRIBUTIONS.get(kind, "")
        names = [name for name, _ in self.shapes["collision"].get(one.feels, ())]
        where = f"joint {one.link}" if one.at_joint else self.content.carrier.get(link, "")
        base = "" if one.at_joint or where == link else link
        if one.at_joint and not self.content.has_joint(self.robot.joint[one.link]):
            why = f'joint "{one.link}" holds nothing that has mass'
        elif one.feels and not names:
            why = f'link "{one.feels}" has no shape that could feel'
        elif not where:
            why = f'"{one.link}" is the world'
        if why:
            self.unseen.setdefault(why, []).append(sensor.name)
            return
        pose = self.pose(IDENTITY if one.at_joint or one.feels else one.pose, base)
        lines = sensor_lines(one.in_classic() if kind == CLASSIC else one, frame_id, self.number, "      ", pose, names)
        self.sensors.setdefault(where, []).append(with_noise("\n".join(lines)))

    def diagnostics(self) -> list[Diagnostic]:
        robot, content, found = self.robot, self.content, list[Diagnostic]()

        def report_lost(message: str, names: Sequence[str], help: str, rule: str = "sdf-cannot-say") -> None:
            if names:
                found.append(Diagnostic(rule, WARNING, f"{message} {quote(names, 3)}", help=help))

        message = f"readers of SDF take a moving link without mass for 1 kg; {LEAST.mass:g} kg is written instead for"
        report_lost(message, content.weightless, 'add "inertial" to the link', "sdf-without-mass")
        axleless = [joint for joint in robot.joints if not joint.moves and not joint.is_fixed]
        names = [joint.name for joint in axleless if joint.type == "planar"]
        message = f"SDF has no planar joints, so in Gazebo nothing constrains {plural('joint', len(names))}"
        report_lost(message, names, "replace a planar joint with two prismatic joints and a continuous joint")
        names = [joint.name for joint in axleless if joint.dynamics and any(astuple(joint.dynamics))]
        message = "SDF has no dynamics for joints with several degrees of freedom, so they are left out for"
        report_lost(message, names, "make each of them several joints, one for each axis")
        names = [name for name, written in self.joints.items() if written != name]
        message = "in the SDF, the suffix _joint is added to joints with the name of a link or frame:"
        report_lost(message, names, "rename the joint in the description")
        followers, older = [joint.name for joint in robot.joints if joint.mimic], self.version in (OLDEST, "1.10")
        gazebo = distribution(self.gazebo)
        what = f"SDF {self.version} has" if older else f"Gazebo {gazebo} reads"
        message = f"{what} no mimic: in Gazebo nothing couples {plural('joint', len(followers))}"
        help = f"write 'version: \"{FOLLOWERS}\"' in the output" if older else "use Gazebo harmonic"
        report_lost(message, followers if older or gazebo in ("fortress", CLASSIC) else [], help)
        for link, texts in self.kept.links.items():
            known = {name for one in self.carried[link] for name, _ in self.shapes["collision"].get(one, ())}
            for text in (text for text in texts if 'type="contact"' in text):
                names = _COLLISION.findall(text)
                if names and known.isdisjoint(names):
                    why = f'link "{link}" has no collision "{names[0]}"'
                    self.unseen.setdefault(why, []).extend(_NAME.findall(text)[:1])
        for why, names in self.unseen.items():
            help = 'correct that, or write "gazebo: []" in the sensor to leave it out'
            report_lost(f"Gazebo ignores these sensors because {why}:", names, help, "gazebo-cannot-see")
        found += self.idle
        couplings = [one.name for one in robot.constraints if one.tag not in _LOOPS]
        report_lost("SDF has no constraints between joints except mimic, so it lacks", couplings, 'use "mimic"')
        report_lost("these constraints are not in the SDF:", self.open, "use links of the SDF for both ends")
        closed = [one.name for one in self.loops if one.name not in self.open]
        message, help = "only Drake reads the constraints", 'write "gazebo: classic" for joints that close the loops'
        if self.gazebo:
            message = f"Gazebo {distribution(self.gazebo)} does not close kinematic loops, so it ignores"
            help = "see github.com/gazebosim/gz-physics/issues/25; Gazebo classic closes them"
        report_lost(message, closed if self.gazebo != CLASSIC else [], help)
        if self.kept.left_out:
            message = f"SDF cannot express {first_of(list(self.kept.left_out), 3)}: only readers of URDF know it"
            found.append(Diagnostic("not-in-format", NOTE, message))
        return found
