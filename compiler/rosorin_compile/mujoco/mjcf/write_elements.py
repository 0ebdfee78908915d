"""Format MJCF elements: actuators, equalities, materials, sites, cameras, lights, sensors and default classes.

A sensor element measures at the site of its frame, or at a separate site NAME_site if it has a pose.

The root of all default classes has the name of the robot, which is also the prefix of the others, because the robots
in a scene share a namespace. ``childclass`` is not used, so raw MJCF keeps MuJoCo's defaults. Joints (or actuators)
with equal attributes share a class if that makes the file shorter. It is named after the common words of the joints.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import Any, NamedTuple

from markupsafe import Markup

from rosorin_compile.formats.templating import Templates, attributes
from rosorin_compile.model import Pose, Robot, Sensor, Shape, Vector, simulation
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Attribute, Values
from rosorin_compile.mujoco.sections import TARGETS
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.numbers import NumberFormat, numbers, vector
from rosorin_compile.source.xml.elements import found_in

from . import bodies
from .servos import Drive, aims
from .unsupported import is_textured

# Attributes that are never in a default class.
_OWN = {"name", "class", "type", "lengthrange", *TARGETS.values()}
_KINDS = ("joint", "position", "velocity", "motor", "general")  # elements that can share a class

Texts = Mapping[str, str]


class Part(NamedTuple):
    """An element to write, with the attributes of a surrounding <replicate>, if any; or raw XML (``text``)."""

    tag: str
    attributes: Markup | str = ""
    replicate: Markup | str = ""
    text: str = ""


class ClassElement(NamedTuple):
    """An element that may refer to a default class, which is then named after ``joint``."""

    tag: str
    name: str
    values: Texts
    joint: str = ""


class Class(NamedTuple):
    """A default class: its name, the elements that define its attributes, and its child classes."""

    name: str
    parts: Sequence[Part] = ()
    classes: Sequence[Class] = ()


class _Shared(NamedTuple):
    tag: str
    values: Texts
    members: Sequence[int]  # indices of the elements
    words: str  # common words of the names of their joints


class Classes:
    """The default classes for ``elements``. Class names in ``kept``, the raw MJCF of the robot, are not used again."""

    def __init__(self, robot: str, elements: Sequence[ClassElement], kept: Iterable[str]) -> None:
        self._taken = {*re.findall(r'<default\b[^<>]*\bclass="([^"]*)"', "".join(kept)), "main"}
        self.outer = bodies.free_name(robot, self._taken)
        self._elements = elements
        self._names: dict[int, str] = {}
        self._taken |= {self.outer, *map(self.class_name, bodies.CLASSES)}
        self.shared: dict[str, list[_Shared]] = {}
        for shared in (shared for shared in self._groups() if self._saved(shared) > 0):
            name = self._with_joints(shared) or self._called(shared)
            self._taken.add(name)
            self.shared.setdefault(name, []).append(shared)
            self._names |= dict.fromkeys(shared.members, name)

    def class_name(self, purpose: str) -> str:
        """Return the name of the default class for a purpose in ``bodies.CLASSES``, such as "visual"."""
        return f"{self.outer}_{purpose}"

    def print_classes(self, place: int) -> Markup:
        element, name = self._elements[place], self._names.get(place, "")
        common = next((one.values for one in self.shared.get(name, ()) if one.tag == element.tag), {})
        own = {word: text for word, text in element.values.items() if word not in common}
        return attributes(name=element.name) + attributes(**({"class": name} if name else {}), **own)

    def tree(self, used: Collection[str], rolls: bool, groups: Mapping[str, int]) -> Class:
        """Return the root class with a child class for each purpose in ``used``.

        ``rolls`` is true if the wheels collide only with the floor; ``groups`` maps purposes to geom groups.
        """

        def named(purpose: str, tag: str, values: Texts, classes: Sequence[Class] = ()) -> Class:
            return Class(self.class_name(purpose), [Part(tag, attributes(**values))], classes)

        seen = {"group": str(groups.get(bodies.VISUAL, bodies.VISUAL_GROUP))}
        is_seen = not {bodies.VISUAL, bodies.SHOWN, bodies.SHOWN_WHEEL}.isdisjoint(used)
        group = groups.get(bodies.COLLISION, bodies.COLLISION_GROUP if is_seen else 0)
        solid = {"group": str(group)} if group else {}
        solid |= {"density": "0", **(bodies.BESIDE_WHEELS.attributes() if rolls else {})}
        rolling = bodies.ROLLS.attributes()
        inner = {bodies.WHEEL: rolling, bodies.SHOWN: seen, bodies.SHOWN_WHEEL: seen | rolling}
        solids = [named(purpose, "geom", values) for purpose, values in inner.items() if purpose in used]
        made = []
        if bodies.VISUAL in used:
            made.append(named(bodies.VISUAL, "geom", seen | {"contype": "0", "conaffinity": "0", "density": "0"}))
        made += [named(bodies.COLLISION, "geom", solid, solids)] if solids or bodies.COLLISION in used else []
        made.append(named(bodies.FRAME, "site", {"group": str(bodies.FRAME_GROUP)}))
        for name, shared in self.shared.items():
            made.append(Class(name, [Part(one.tag, attributes(**one.values)) for one in shared]))
        return Class(self.outer, (), made)

    def _groups(self) -> Iterator[_Shared]:
        """Yield groups of elements that can share a class, split if that saves more or gives clearer names."""
        for members in self._alike(range(len(self._elements)), ("axis", "range", "ctrlrange", "forcerange")):
            whole, cut = self._shared(members), self._alike(members, ())
            parts = [self._shared(inner) for inner in cut] if len(cut) > 1 else [whole]
            saved = [self._saved(one) for one in parts]
            apart = len({one.words for one in parts} - {"", "joint"}) == len(parts) and min(saved) > 0
            yield from parts if apart or sum(max(0, more) for more in saved) >= self._saved(whole) else [whole]

    def _alike(self, places: Iterable[int], without: Sequence[str]) -> list[list[int]]:
        groups: dict[object, list[int]] = {}
        for place in places:
            tag, values = self._elements[place].tag, self._elements[place].values
            key = frozenset((word, text) for word, text in values.items() if word not in (*_OWN, *without))
            groups.setdefault((tag, key if tag in _KINDS else place), []).append(place)
        return list(groups.values())

    def _shared(self, members: Sequence[int]) -> _Shared:
        elements = [self._elements[place] for place in members]
        shared = set.intersection(*(set(one.values.items()) for one in elements))
        common = [pair for pair in elements[0].values.items() if pair in shared and pair[0] not in _OWN]
        return _Shared(elements[0].tag, dict(common), members, _words_of([one.joint for one in elements]))

    def _with_joints(self, shared: _Shared) -> str:
        """Return the name of the class that all joints of these actuators share, or "" if there is none."""
        joints = {self._elements[place].joint for place in shared.members}
        for name, (first, *more) in self.shared.items() if shared.tag != "joint" else ():
            if first.tag == "joint" and not more and joints <= {self._elements[place].joint for place in first.members}:
                return name
        return ""

    def _called(self, shared: _Shared) -> str:
        first = self._elements[shared.members[0]].joint
        own, word = _words_of([first]), shared.words or shared.tag
        words = [word, own if "_" in own else first or shared.tag]
        words += [f"{word}_{n}" for n in range(2, len(self._taken) + 2)]
        return next(name for name in map(self.class_name, words) if name not in self._taken)

    def _saved(self, shared: _Shared) -> int:
        joined = self._with_joints(shared)
        name = joined or self._called(shared)
        size, naming = len(attributes(**shared.values)), len(f' class="{name}"')
        around = f"        <{shared.tag}/>\n" + f'      <default class="{name}">\n      </default>\n' * (not joined)
        return len(shared.members) * (size - naming) - size - len(around) if size else 0


def _words_of(names: Sequence[str]) -> str:
    """Return the common first and last words of names, without numbers, and without "joint" if other words remain.

    >>> _words_of(["wrist_1_joint", "wrist_2_joint"]), _words_of(["FL_hip_joint", "FR_hip_joint"])
    ('wrist', 'hip')
    >>> _words_of(["joint1", "joint2"]), _words_of(["pan", "tilt"])
    ('joint', '')
    """
    split = [re.findall(r"[^\W\d_]+", name) for name in names]
    begin = len(posixpath.commonprefix(split))
    end = len(posixpath.commonprefix([words[begin:][::-1] for words in split]))
    words = split[0][:begin] + split[0][len(split[0]) - end :]
    return "_".join([word for word in words if word != "joint"] or words[:1])


# Attributes that refer to a body. Their link names are replaced by body names.
_BODIES = ("body", "body1", "body2", "target", "subtree1", "subtree2")
_NAMED = ("objname", "refname")
_GEOMS = ("geom", "geom1", "geom2", *_NAMED)


@lru_cache(maxsize=20_000)
def place_of(xyz: Vector, rpy: Vector, number: NumberFormat) -> Mapping[str, str]:
    """Return the attributes ``pos`` (m) and ``quat`` (w x y z) of a pose, without those that are zero."""
    quaternion = Pose(xyz, rpy).transform().quaternion()
    made = {"pos": vector(xyz, number)} if any(xyz) else {}
    return made if quaternion == (1, 0, 0, 0) else {**made, "quat": vector(quaternion, number)}


class ElementPrinter:
    """A formatter for elements other than bodies; ``colours`` are the materials of visible collision shapes."""

    def __init__(self, robot: Robot, number: NumberFormat, colours: Iterable[Material] = ()) -> None:
        self.robot = robot
        self.number = number
        self.looks = {**robot.material, **{one.name: one for one in colours}}
        # Names of geoms by LINK_PURPOSE_NUMBER, for geoms that have a different name.
        self.own_names: dict[str, str] = {}
        # Names of textures by file, and names of materials that only have a texture, by texture.
        self.textures: dict[str, str] = {}
        self.plain: dict[str, str] = {}

    def actuator(self, drive: Drive) -> ClassElement:
        """Return an actuator as an element, with its target, gains, ranges and other attributes."""
        actuator = drive.actuator
        values: dict[str, Attribute] = dict(actuator.targets)
        values = {"joint": drive.joint.name} if drive.joint is not None and drive.in_joint else values
        values |= {"kp": actuator.kp, "kv": actuator.kv or None, "dampratio": actuator.damping_ratio or None}
        values |= {"gear": actuator.gear or None, "ctrlrange": aims(drive), "forcerange": actuator.force}
        texts = self.texts({"name": drive.name, **values, **actuator.mjcf})
        return ClassElement(actuator.type, texts.pop("name"), texts, drive.joint.name if drive.joint else "")

    def material(self, name: str) -> str:
        """Return the name of a material in the MJCF, or "" if the MJCF does not contain it."""
        material = self.looks.get(name)
        has_look = material and (material.rgba or material.mjcf or is_textured(self.robot, material.texture))
        return f"{self.robot.name}_{name}" if has_look else ""

    def materials(self) -> Iterator[Values]:
        for name, material in self.looks.items():
            if called := self.material(name):
                texture = None if "texture" in material.mjcf else self.texture(material.texture) or None
                yield {"name": called, "texture": texture, "rgba": material.rgba, **material.mjcf}
        yield from ({"name": name, "texture": texture} for texture, name in self.plain.items())

    def texture(self, file: str) -> str:
        """Return the name of the texture for an image file, or "" if the MJCF does not contain it."""
        if not is_textured(self.robot, file):
            return ""
        if file not in self.textures:
            name = f"{self.robot.name}_{posixpath.splitext(posixpath.basename(file))[0]}"
            self.textures[file] = bodies.free_name(name, self.textures.values())
        return self.textures[file]

    def look(self, visual: Shape) -> dict[str, str]:
        """Return the attributes ``material`` and ``rgba`` of a visual, each only if it is needed."""
        material = self.robot.material.get(visual.material) if visual.material else None
        named = self.material(visual.material) if material else ""
        if named and visual.rgba is None and not visual.texture:  # nothing overrides the material
            return {"material": named}
        file = self.robot.texture(visual)
        texture = self.texture(file)
        if texture and "material" not in visual.mjcf and not (material and material.texture == file):
            if texture not in self.plain:  # add a material with only the texture
                own = [self.material(name) for name in self.looks]
                self.plain[texture] = bodies.free_name(texture, [*own, *self.plain.values()])
            named = self.plain[texture]
        colour = self.robot.colour(visual)
        own_colour = colour if colour and not (named and material and colour == material.rgba) else None
        look = {"material": named} if named else {}
        return {**look, "rgba": numbers(own_colour, self.number)} if own_colour else look

    def constraint(self, entry: simulation.Entry) -> Part:
        """Return a constraint as an element; in MJCF, its polynomial is relative to ``ref`` of the joints."""
        known = (self.robot.joint.get(str(entry.values.get(word, ""))) for word in ("joint1", "joint2"))
        first, second = (bodies.reference(joint) if joint else 0.0 for joint in known)
        values = {"name": entry.name, **entry.values}
        if first or second:
            value = entry.values.get("polycoef")
            before = list(map(float, value)) if isinstance(value, tuple) else [0.0, 1.0]
            offset, *others = bodies.shift_polynomial(before, second)
            values["polycoef"] = (offset - first, *others)
        return Part(entry.tag, self.print_values(values))

    def mark(self, mark: simulation.Attachment) -> Part:
        place = place_of(mark.pose.xyz, mark.pose.rpy, self.number)
        values = {key: value for key, value in mark.values.items() if value is not None}
        if mark.tag == "light":  # a light has a direction instead of a rotation
            place = {key: text for key, text in place.items() if key == "pos"}
            value = values.get("dir")
            x, y, z = map(float, value) if isinstance(value, tuple) else (0.0, 0.0, -1.0)
            if value is not None or any(mark.pose.rpy):
                values["dir"] = mark.pose.transform().rotate((x, y, z))
        return Part(mark.tag, attributes(name=mark.name, **place) + self.print_values(values))

    def contact_attributes(self, shape: Shape, purpose: str) -> dict[str, str]:
        """Return the attributes in the sections ``contact`` (only of a collision shape) and ``mjcf`` of a shape."""
        contact = shape.contact.values if shape.contact is not None and purpose == "collision" else {}
        bits = {word: contact.get(word) for word in bodies.BITS}  # put the contact bits first
        return self.texts({**bits, **contact, **shape.mjcf})

    def print_values(self, values: Values) -> Markup:
        return attributes(**self.texts(values))

    def texts(self, values: Values) -> dict[str, str]:
        texts = {name: self.text(value) for name, value in values.items() if value is not None}
        for name in frozenset({*_BODIES, *_GEOMS, "material"}).intersection(texts):
            text = texts[name]
            named = name in _BODIES or (name in _NAMED and values.get(f"{name[:3]}type") == "xbody")
            if named and values[name] in self.robot.link:
                texts[name] = bodies.body_name(self.robot, text)
            elif name in _GEOMS:
                texts[name] = self.own_names.get(text, text)
            elif name == "material":
                texts[name] = self.material(text) or text
        return texts

    def text(self, value: Attribute) -> str:
        if isinstance(value, tuple):
            return " ".join([self.number(one or 0.0) if type(one) is float else self.text(one) for one in value])
        if isinstance(value, bool):
            return "true" if value else "false"
        return value if isinstance(value, str) else self.number(value or 0.0)


class SensorElements(NamedTuple):
    """The MJCF elements of all sensors; ``kept`` is the raw MJCF of the robot that ``sensors`` does not include."""

    of_bodies: dict[str, list[Part]]
    sensors: list[Part]
    sections: list[tuple[str, str]]  # (MJCF section, raw XML)
    kept: list[str]
    diagnostics: list[Diagnostic]


def sensor_parts(robot: Robot, templates: Templates, printer: ElementPrinter, order: Sequence[str]) -> SensorElements:
    """Return the elements of all sensors, sorted by the names in ``order``. Raises TemplateProblem."""
    made, number = SensorElements({}, [], [], list(robot.mjcf), []), printer.number
    for sensor, part in [(one, part) for one in robot.sensors for part in one.simulated]:
        place = place_of(part.pose.xyz, part.pose.rpy, number) if part.pose is not None else {}
        around, of_body = Markup(), made.of_bodies.setdefault(part.link, [])
        if part.replicas is not None:
            step = {"offset": part.replicas.step.xyz, "euler": part.replicas.step.rpy}
            turned = {word: vector(one, number) for word, one in step.items() if any(one)}
            around = attributes(count=str(part.replicas.count), sep="_", **turned)
        more = {name: printer.text(value) for name, value in part.attributes.items() if value is not None}
        if part.kind == simulation.TEMPLATE_ELEMENT:
            names: dict[str, Any] = {"robot": robot, "sensor": sensor, "element": part, "number": number}
            text = templates.render(part.element, {**names, "vector": partial(vector, number=number)}).strip()
            made.diagnostics.extend(_damaged(sensor, part, text))
            if part.section:
                made.sections.append((part.section, text))
            else:
                of_body.append(Part("", text=text))
        elif part.kind == simulation.BODY_ELEMENT:
            of_body.append(Part(part.element, attributes(**{"name": part.name, **place, **more}), around))
        elif part.kind == simulation.SENSOR_ELEMENT:
            at = {"objtype": "site", "objname": part.site} if part.element.startswith("frame") else {"site": part.site}
            without = [name for name, value in part.attributes.items() if value is None]  # null removes an attribute
            values = {name: value for name, value in {"name": part.name, **at}.items() if name not in without}
            made.sensors.append(Part(part.element, attributes(**{**values, **more})))
            of_body += [Part("site", attributes(name=part.site, **place), around)] if part.pose is not None else []
    if not order:
        return made
    made.kept.clear()
    for text in robot.mjcf:  # move sensors in raw MJCF to the others, to sort all of them
        found = found_in(text)
        if found and all(one.tags[0] == "sensor" and len(one.tags) <= 2 for one in found):
            made.sensors.extend(Part(one.tags[1], attributes(**one.attributes)) for one in found if len(one.tags) == 2)
        else:
            made.kept.append(text)
    rank = {name: place for place, name in enumerate(order)}
    made.sensors.sort(key=lambda one: rank.get("".join(re.findall(r' name="([^"]*)"', one.attributes)), len(rank)))
    return made


def _damaged(sensor: Sensor, part: simulation.SensorElement, text: str) -> Iterator[Diagnostic]:
    from xml.etree import ElementTree

    what, around = f'the output of {part.element} for sensor "{sensor.name}"', part.section or "body"
    help = "correct the XML: close every element, and put every value in quotes"
    try:
        made = ElementTree.fromstring(f"<{around}>{text}</{around}>")  # noqa: S314 - no DOCTYPE is possible here
    except ElementTree.ParseError as problem:
        yield error("template-failed", f"{what} is not XML: {problem}", None, help)
        return
    if any(True for name in ("joint", "freejoint") for _ in made.iter(name)):
        yield error("template-failed", f"{what} contains a joint", None, 'define it in "joints" of the description')
    if any(not body.get("name") for body in made.iter("body") if body is not made):
        yield error("template-failed", f"{what} contains a body without a name", None, "name it")
