"""What only a simulation has, in MJCF: actuators, equalities, and marks of bodies."""

from __future__ import annotations

import posixpath
from collections.abc import Collection, Iterable, Iterator, Mapping

from markupsafe import Markup

from rosorin_compile.formats.templating import attributes
from rosorin_compile.model import Robot, Shape
from rosorin_compile.model.shape import Material
from rosorin_compile.model.simulation import Attribute, Entry, Marked, Values
from rosorin_compile.source.numbers import NumberFormat

from .bodies import body_name, reference, shifted
from .classes import Named, Part
from .masks import BITS
from .omissions import is_textured
from .servos import Drive, aims

# Attributes that name a body; what is called like a link is the body of it.
_BODIES = ("body", "body1", "body2", "target", "subtree1", "subtree2")
_NAMED = ("objname", "refname")
_GEOMS = ("geom", "geom1", "geom2", *_NAMED)
_NAMING = frozenset({*_BODIES, *_GEOMS, "material"})


class SimulationPrinter:
    """Puts what only a simulation has into the terms of MuJoCo, numbers printed.

    ``colours`` are materials of links that are seen as their collision shapes.
    """

    def __init__(self, robot: Robot, number: NumberFormat, colours: Iterable[Material] = ()) -> None:
        self.robot = robot
        self.number = number
        self.looks = {**robot.material, **{one.name: one for one in colours}}
        # Geoms that have a name of their own, by the one that their place in the link would give them.
        self.own_names: dict[str, str] = {}
        # The textures by their names in the description, and the materials that are one of them alone, by its name.
        self.textures: dict[str, str] = {}
        self.plain: dict[str, str] = {}

    def actuator(self, drive: Drive) -> Named:
        """Return the element of an actuator: its name, what it acts on, its gains, its ranges, all else."""
        actuator = drive.actuator
        values: dict[str, Attribute] = dict(actuator.targets)
        if drive.joint is not None and drive.beside:
            values = {"joint": drive.joint.name}
        values |= {"kp": actuator.kp, "kv": actuator.kv or None, "dampratio": actuator.damping_ratio or None}
        values["gear"] = actuator.gear or None
        values["ctrlrange"] = aims(drive)
        values["forcerange"] = actuator.force
        texts = self.texts({"name": drive.name, **values, **actuator.mjcf})
        name = texts.pop("name")
        return Named(actuator.type, name, texts, drive.joint.name if drive.joint else "")

    def material(self, name: str) -> str:
        """Return the name of a material in the file, where all begin with that of the robot; empty if it has none."""
        material = self.looks.get(name)
        has_look = material and (material.rgba or material.mjcf or is_textured(self.robot, material.texture))
        return f"{self.robot.name}_{name}" if has_look else ""

    def materials(self) -> Iterator[Values]:
        """Yield the attributes of each material: those of the robot, then those that are a texture alone."""
        for name, material in self.looks.items():
            called = self.material(name)
            if called:
                texture = None if "texture" in material.mjcf else self.texture(material.texture) or None
                yield {"name": called, "texture": texture, "rgba": material.rgba, **material.mjcf}
        for texture, name in self.plain.items():
            yield {"name": name, "texture": texture}

    def texture(self, file: str) -> str:
        """Return the name of a texture in the file: that of its image; empty if the file has none."""
        if not is_textured(self.robot, file):
            return ""
        if file not in self.textures:
            name = f"{self.robot.name}_{posixpath.splitext(posixpath.basename(file))[0]}"
            self.textures[file] = free(name, self.textures.values())
        return self.textures[file]

    def material_of(self, file: str) -> str:
        """Return the name of a material that is a texture alone; empty if the file has none."""
        texture = self.texture(file)
        if texture and texture not in self.plain:
            own = [self.material(name) for name in self.looks]
            self.plain[texture] = free(texture, [*own, *self.plain.values()])
        return self.plain.get(texture, "")

    def constraint(self, entry: Entry) -> Part:
        """Return the element of a constraint; MuJoCo counts both joints of a polynomial from their references."""
        known = (self.robot.joint.get(str(entry.values.get(word, ""))) for word in ("joint1", "joint2"))
        first, second = (reference(joint) if joint else 0.0 for joint in known)
        values = {"name": entry.name, **entry.values}
        if first or second:
            said = entry.values.get("polycoef")
            offset, *others = shifted(list(map(float, said)) if isinstance(said, tuple) else [0.0, 1.0], second)
            values["polycoef"] = (offset - first, *others)
        return Part(entry.tag, self.printed(values))

    def mark(self, mark: Marked, place: Mapping[str, str]) -> Part:
        """Return a site, a camera or a light; ``place`` are the attributes of its pose."""
        values = {key: value for key, value in mark.values.items() if value is not None}
        if mark.tag == "light":  # which has no axes but a direction
            place = {key: text for key, text in place.items() if key == "pos"}
            said = values.get("dir")
            x, y, z = map(float, said) if isinstance(said, tuple) else (0.0, 0.0, -1.0)
            if said is not None or any(mark.pose.rpy):
                values["dir"] = mark.pose.transform().rotate((x, y, z))
        return Part(mark.tag, attributes(name=mark.name, **place) + self.printed(values))

    def touching(self, shape: Shape, purpose: str) -> dict[str, str]:
        """Return the attributes of how a shape touches, and those that the language has no word for."""
        values: dict[str, Attribute] = {}
        if shape.contact is not None and purpose == "collision":
            bits: Values = {word: shape.contact.values.get(word) for word in BITS}  # first in the element
            values |= {**bits, **shape.contact.values}
        return self.texts(values | dict(shape.mjcf))

    def printed(self, values: Values) -> Markup:
        """Return attributes as text; what is None is left out."""
        return attributes(**self.texts(values))

    def texts(self, values: Values) -> dict[str, str]:
        """Return attributes printed, by name."""
        texts = {name: self.text(value) for name, value in values.items() if value is not None}
        for name in _NAMING.intersection(texts):
            text = texts[name]
            named = name in _BODIES or (name in _NAMED and values.get(f"{name[:3]}type") == "xbody")
            if named and values[name] in self.robot.link:
                texts[name] = body_name(self.robot, text)
            elif name in _GEOMS:
                texts[name] = self.own_names.get(text, text)
            elif name == "material":
                texts[name] = self.material(text) or text
        return texts

    def text(self, value: Attribute) -> str:
        """Return the value of an attribute as text."""
        if isinstance(value, tuple):
            return " ".join([self.number(one or 0.0) if type(one) is float else self.text(one) for one in value])
        if isinstance(value, bool):
            return "true" if value else "false"
        return value if isinstance(value, str) else self.number(value or 0.0)


def free(name: str, taken: Collection[str]) -> str:
    """Return a name, with underscores behind it if it is taken."""
    while name in taken:
        name += "_"
    return name
