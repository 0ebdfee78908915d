"""What a format does not carry of a description, and the note that says so.

In ``unsupported`` "*" stands for the name of an entry: ``joints.*.dynamics.damping``; messages leave it out. A key
stands for all keys below it. A format carries the keys that it ``covers``, without those that are ``unsupported`` and
those that name another format (``mjcf``, ``gazebo``).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Link, Output
from rosorin_compile.model.link import limited_fields
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import counted, listed

if TYPE_CHECKING:
    from .format import Format

_NOTE = "A note: a format cannot express keys that the description sets; one note a format."
_NOTHING = "Nothing, if no reader of these artifacts needs them; accept the rule with the reason."
RULES = (Rule("not-in-format", _NOTE, _NOTHING, FORMATS),)

# Keys that name the formats that they are for: a reader of another one does not expect them.
ADDRESSED: Mapping[str, tuple[str, ...]] = {
    "mjcf": ("mjcf",),
    "mjcf_elements": ("mjcf",),
    "gazebo": ("sdf", "urdf"),
    "urdf_elements": ("urdf",),
}
# What says how the description is read and checked, and keys of any entry that say where its values come from.
ABOUT_THE_DESCRIPTION = (
    *("args", "let", "include", "accept", "outputs", "rosorin_compile", "modes", "links.inertial.of.name"),
)
REMARKS = frozenset({"source", "stand_ins", "method", "reason", "about", "stamps"})

# The keys that give a frame its place, and those that name the node that publishes it.
PLACES = (
    *("joints.parent", "joints.child", "joints.xyz", "joints.rpy", "sensors.parent", "sensors.frame"),
    *("sensors.xyz", "sensors.rpy", "sensors.optical.frame", "sensors.optical.xyz", "sensors.optical.rpy"),
)
_PUBLISHER = ("joints.publisher", "sensors.publisher", "sensors.optical.publisher")
NODES = tuple(
    f"{publisher}{turn}"
    for publisher in _PUBLISHER
    for turn in (".static_transform_publisher", ".by.static_transform_publisher", ".when")
)
UNPUBLISHED = tuple(f"{publisher}.none" for publisher in _PUBLISHER)

# The keys that each format of a whole robot covers.
MODEL_KEYS = ("robot", "links", "joints", "materials", "sensors", "root", "actuators", "disabled_contacts")

_GEOMETRY = (
    *("box", "cylinder", "capsule", "sphere", "ellipsoid", "mesh.file", "mesh.scale", "height_map.origin"),
    *("height_map.cell", "height_map.heights", "height_map.bottom", "xyz", "rpy"),
)
SHAPES = tuple(f"links.{purpose}.{key}" for purpose in ("collision", "visual") for key in _GEOMETRY)


class Unsupported(NamedTuple):
    """Why a format does not carry a key."""

    reason: str
    quiet: bool = False  # a note would help nobody, because something else carries it
    one_way: bool = False  # artifacts carry it, but not the robot that is read from one: ``diff`` does not compare it


def _quiet(reason: str, *keys: str) -> dict[str, Unsupported]:
    return {key: Unsupported(reason, quiet=True) for key in keys}


_CONTACTS = ("condim", "priority", "solmix", "solref", "solimp", "margin", "gap")
# How MuJoCo sees and simulates a robot, in words that formats for other programs do not have.
OF_MUJOCO: Mapping[str, Unsupported] = {
    **_quiet("how MuJoCo couples joints", *(f"joints.*.mimic.{key}" for key in ("name", *_CONTACTS))),
    **_quiet("how MuJoCo computes contacts", *(f"links.*.collision.*.contact.{key}" for key in _CONTACTS)),
    **_quiet("marks that sensors and actuators of MuJoCo name", "links.*.sites"),
    **_quiet("what MuJoCo takes a mesh for", "links.*.collision.*.mesh.inertia", "links.*.visual.*.mesh.inertia"),
    **_quiet("how the base moves in the world of a simulation", "root"),
    "joints.*.dynamics.armature": Unsupported("no inertia of rotors"),
    "links.*.cameras": Unsupported("cameras that are not sensors"),
    "links.*.lights": Unsupported("no lights"),
    "links.*.collision.*.contact.friction.1": Unsupported("sliding friction alone"),
    "links.*.collision.*.contact.contype": Unsupported("no bits of contacts"),
    "links.*.collision.*.contact.conaffinity": Unsupported("no bits of contacts"),
}
# Who publishes a frame; the name of a sensor's joint matters to publishers alone. What frames sensors have is read.
OF_PUBLISHERS: Mapping[str, Unsupported] = {
    **_quiet("for launch files, and the table of frames", "joints.*.publisher"),
    **_quiet("for launch files, and the table of frames", "sensors.*.publisher", "sensors.*.optical.publisher"),
    "sensors": Unsupported("sensors are read as links", one_way=True),
}


def is_within(key: str, prefixes: Iterable[str]) -> bool:
    """Return True if a key is one of some keys, or below one of them; "*" in these stands for any name."""
    return any(f"{key}.".startswith(f"{prefix.replace('.*', '')}.") for prefix in prefixes)


def reason(format: Format, output: Output, key: str, one_way: bool = False) -> Unsupported | None:
    """Return why an output, or (``one_way``) the robot read from it, has nothing at a key; None if it has to."""
    steps = key.split(".")
    if is_within(key, ABOUT_THE_DESCRIPTION) or not REMARKS.isdisjoint(steps):
        return Unsupported("it is about the description", quiet=True)
    for step in steps:
        if format.name not in ADDRESSED.get(step, (format.name,)):
            return Unsupported(f"{step} is for {listed(ADDRESSED[step])}", quiet=True)
    table = _table(format, output).items()
    found = [why for prefix, why in table if is_within(key, [prefix]) and (one_way or not (why and why.one_way))]
    if None not in found and format.covers and not is_within(key, format.covers):
        return Unsupported(f"a {format.word} has {listed(format.covers)}", quiet=True)
    return None if None in found or not found else found[0]


def lacks(format: Format, key: str) -> bool:
    """Return True if the robots that are read from artifacts of a format, by default options, have nothing at a key."""
    return reason(format, Output(format.name, format.name, ""), key, one_way=True) is not None


def _table(format: Format, output: Output) -> Mapping[str, Unsupported | None]:
    """Return what an output does not carry, and None for keys of links that this format and few others carry."""
    found: dict[str, Unsupported | None] = {}
    found.update(format.unsupported(output) if callable(format.unsupported) else format.unsupported)
    for name, formats in limited_fields(Link).items():
        if format.name in formats:
            found[f"links.*.{name}"] = None
        elif "links" in format.covers:
            found[f"links.*.{name}"] = Unsupported(f"only in {listed(formats)}")
    return found


def notes(tree: Map, outputs: Iterable[Output], formats: Mapping[str, Format]) -> Iterator[Diagnostic]:
    """Yield a note for each format of which no output carries keys that a description sets."""
    outputs = list(outputs)
    for name in dict.fromkeys(output.backend for output in outputs):
        some = [output for output in outputs if output.backend == name]
        first, *others = [_table(formats[name], output) for output in some]
        lost = [key for key, why in first.items() if why and not (why.quiet or why.one_way)]
        counts = {key: len([*_places(tree, key)]) for key in lost if all(table.get(key) for table in others)}
        found = [f"{key.replace('.*', '')} ({counted(count, 'place')})" for key, count in counts.items() if count]
        if found:
            span = tree.locate(("outputs", some[0].name), key=True).span
            yield Diagnostic("not-in-format", NOTE, f"{formats[name].word} cannot express {listed(found)}", span)


def _places(value: Any, pattern: str) -> Iterator[Any]:
    """Yield the values that are set at a key; "*" stands for each entry of a mapping or a list, 1 for the second."""
    step, _, rest = pattern.partition(".")
    if step == "*":
        inner = list(value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else ())
    elif isinstance(value, list):
        inner = value[int(step) : int(step) + 1] if step.isdecimal() else []
    else:
        inner = [value[step]] if isinstance(value, Mapping) and step in value else []
    for item in inner:
        if rest:
            yield from _places(item, rest)
        elif item not in (None, [], {}, False):
            yield item
