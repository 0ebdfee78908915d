"""What only a simulation has, in MJCF: actuators, tendons, equalities, sensors, contact pairs, and marks of bodies."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from markupsafe import Markup

from ...model import Attribute, Contact, ContactPair, Entry, Marked, Robot, Shape, Tendon, Values
from ...model.simulation import SHARED_LAYER
from ...numbers import NumberFormat
from ..templating import attributes
from .bodies import body_name
from .servos import Drive, aims

# Attributes that name a body; what is called like a link is the body of it.
_BODIES = ("body", "body1", "body2", "target", "subtree1", "subtree2")


class Part(NamedTuple):
    """An element as printed, with what stands in it."""

    tag: str
    attributes: Markup
    elements: Sequence[Part] = ()


class Simulated(NamedTuple):
    """The sections of a file, each a list of elements."""

    actuators: Sequence[Part]
    tendons: Sequence[Part]
    equalities: Sequence[Part]
    sensors: Sequence[Part]
    pairs: Sequence[Part]


class SimulationPrinter:
    """Puts what only a simulation has into the terms of MuJoCo, numbers printed."""

    def __init__(self, robot: Robot, number: NumberFormat) -> None:
        self.robot = robot
        self.number = number
        self.layers = {name: 1 << bit for bit, name in enumerate(contact_layers(robot))}

    def sections(self, drives: Sequence[Drive], geoms: Callable[[str], Sequence[str]]) -> Simulated:
        """Return all sections; ``geoms`` returns the names of the geoms with which a link collides."""
        simulation = self.robot.simulation
        return Simulated(
            [self.actuator(drive) for drive in drives],
            [self.tendon(tendon) for tendon in simulation.tendons],
            [self.entry(constraint) for constraint in simulation.constraints],
            [self.entry(sensor) for sensor in simulation.sensors],
            [part for pair in simulation.contact_pairs for part in self.pair(pair, geoms)],
        )

    def actuator(self, drive: Drive) -> Part:
        """Return the element of an actuator: its name, what it acts on, its gains, its ranges, all else."""
        actuator = drive.actuator
        values: dict[str, Attribute] = dict(actuator.targets)
        if drive.joint is not None and drive.beside:
            values = {"joint": drive.joint.name}
        values |= {"kp": actuator.kp, "kv": actuator.kv or None, "dampratio": actuator.damping_ratio or None}
        values["gear"] = actuator.gear or None
        values["ctrlrange"] = aims(drive)
        values["forcerange"] = actuator.force
        return Part(actuator.type, self.printed({"name": drive.name, **values, **actuator.mjcf}))

    def tendon(self, tendon: Tendon) -> Part:
        """Return the element of a tendon with its joints or its path."""
        joints = [
            Part("joint", self.printed({"joint": joint, "coef": factor})) for joint, factor in tendon.joints.items()
        ]
        path = [Part(stop.tag, self.printed(stop.values)) for stop in tendon.path]
        tag = "fixed" if tendon.joints else "spatial"
        return Part(tag, self.printed({"name": tendon.name, **tendon.values}), joints or path)

    def entry(self, entry: Entry) -> Part:
        """Return the element of an entry of a list."""
        return Part(entry.tag, self.printed({"name": entry.name, **entry.values}))

    def pair(self, pair: ContactPair, geoms: Callable[[str], Sequence[str]]) -> Iterator[Part]:
        """Yield the elements of a pair: one, or of two links one for each shape of the one with each of the other."""
        if pair.shapes is not None:
            one, other = pair.shapes
            yield Part("pair", self.printed({"name": pair.name or None, "geom1": one, "geom2": other, **pair.values}))
            return
        first, second = pair.links or ("", "")
        both = [(one, other) for one in geoms(first) for other in geoms(second)]
        for number, (one, other) in enumerate(both, 1):
            name = pair.name if len(both) == 1 else f"{pair.name}_{number}"
            named = {"name": name} if pair.name else {}
            yield Part("pair", self.printed({**named, "geom1": one, "geom2": other, **pair.values}))

    def mark(self, mark: Marked, place: Mapping[str, str]) -> Part:
        """Return a site, a camera or a light; ``place`` are the attributes of its pose."""
        values = {key: value for key, value in mark.values.items() if value is not None}
        return Part(mark.tag, Markup("").join([attributes(name=mark.name, **place), self.printed(values)]))

    def touching(self, shape: Shape, purpose: str) -> dict[str, str]:
        """Return the attributes of how a shape touches, and those that the language has no word for."""
        values: dict[str, Attribute] = {}
        if shape.contact is not None and purpose == "collision":
            values |= self.masks(shape.contact) | dict(shape.contact.values)
        return self.texts(values | dict(shape.mjcf))

    def masks(self, contact: Contact) -> dict[str, Attribute]:
        """Return contype and conaffinity; the bits of a layer are its place among all."""
        both = {"contype": contact.layers, "conaffinity": contact.touches}
        return {
            word: sum(self.layers[name] for name in set(names)) for word, names in both.items() if names is not None
        }

    def printed(self, values: Values) -> Markup:
        """Return attributes as text; what is None is left out."""
        return attributes(**self.texts(values))

    def texts(self, values: Values) -> dict[str, str]:
        """Return attributes printed, by name."""
        texts = {}
        for name, value in values.items():
            if value is None or name == "material":  # the file has colours alone
                continue
            named = name in _BODIES or (name in ("objname", "refname") and values.get(f"{name[:3]}type") == "xbody")
            texts[name] = body_name(self.robot, str(value)) if named and value in self.robot.link else self.text(value)
        return texts

    def text(self, value: Attribute) -> str:
        """Return the value of an attribute as text."""
        if isinstance(value, tuple):
            return " ".join(self.text(item) for item in value)
        if isinstance(value, bool):
            return "true" if value else "false"
        return value if isinstance(value, str) else self.number(value or 0.0)


def contact_layers(robot: Robot) -> tuple[str, ...]:
    """Return the layers of contacts, in the order of their bits; the first is that of shapes that name none."""
    if robot.simulation.contact_layers:
        return robot.simulation.contact_layers
    named = {
        name
        for link in robot.links
        for shape in link.collision
        if shape.contact is not None
        for name in (*(shape.contact.layers or ()), *(shape.contact.touches or ()))
    }
    return (SHARED_LAYER, *sorted(named - {SHARED_LAYER}))
