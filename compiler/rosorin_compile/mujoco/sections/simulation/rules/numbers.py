"""Numbers of what only a simulation has: ranges with room, contacts that there can be, layers that are known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.model.simulation import SHARED_LAYER
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Suggestion, counted, did_you_mean
from rosorin_compile.source.rule_registry import Check, Heading, rule
from rosorin_compile.source.tree import Path, at

from .actuators import drivers

# MuJoCo has a bit for each.
MOST_LAYERS = 31
_CONDIMS = (1, 3, 4, 6)
# Words of MuJoCo whose two numbers are a smallest and a largest one.
_RANGES = ("range", "force", "actrange", "lengthrange", "velrange", "ffrange", "posrange", "actuatorfrcrange")
_SIZES = {
    "damping": "it would drive instead of braking",
    "friction": "it would drive instead of braking",
    "armature": "no rotor has such an inertia",
    "stiffness": "the spring would push away from where it is at rest",
    "kp": "the servo would drive away from where it shall be",
    "kv": "the servo would drive instead of braking",
    "damping_ratio": "the servo would drive instead of braking",
}


@rule(
    "range-without-room",
    "A range for a simulation has no room: its first number is not below its second one, which MuJoCo takes for no "
    "range, or refuses.",
    "Give the smaller number first; leave the range out where there is none.",
    Heading.SIMULATED,
)
def ranges(case: Case) -> Iterator[Diagnostic]:
    """Ranges of actuators, tendons and joints in which nothing lies."""
    for entry, path, called in _entries(case):
        for inner, place in ((entry, path), (entry.get("mjcf") or {}, (*path, "mjcf"))):
            for key in _RANGES:
                ends = inner.get(key)
                if isinstance(ends, list) and len(ends) == 2 and not ends[0] < ends[1]:
                    message = f"the {key} of {called} goes from {number(ends[0])} to {number(ends[1])}"
                    help = "give the smaller number first, or leave it out where there is none"
                    yield case.problem("range-without-room", message, (*place, key), help)


def _entries(case: Case) -> Iterator[tuple[Mapping[str, Any], Path, str]]:
    """Yield the entries that have ranges and sizes of a simulation, with their paths and what they are called."""
    tree = case.tree
    for driver in drivers(case):
        yield at(case.tree, driver.path), driver.path, driver.called
    for name, entry in (tree.get("tendons") or {}).items():
        yield entry, ("tendons", name), f'tendon "{name}"'
    for name, entry in (tree.get("joints") or {}).items():
        if entry.get("mjcf"):
            yield {"mjcf": entry["mjcf"]}, ("joints", name), f'joint "{name}"'
    if tree.get("root"):
        yield tree["root"], ("root",), "the root"


@Check
def negative(case: Case) -> Iterator[Diagnostic]:
    """Sizes below zero (dynamics-negative) beside those of joints."""
    for entry, path, called in _entries(case):
        if path[0] == "joints" and len(path) > 2:  # an actuator that stands with its joint
            keys: Sequence[str] = ("damping_ratio",)
        else:
            keys = tuple(_SIZES)
        for key in keys:
            value = entry.get(key, 0.0)
            if isinstance(value, (int, float)) and value < 0:
                message = f"the {key} of {called} is {number(value)}, below zero: {_SIZES[key]}"
                yield case.problem("dynamics-negative", message, (*path, key), "write it without the sign")


@rule(
    "contact-value",
    "A contact has a number that there is not: `condim` is 1, 3, 4 or 6, friction and margins are not below zero.",
    "As the message says.",
    Heading.SIMULATED,
)
def contacts(case: Case) -> Iterator[Diagnostic]:
    """Contacts that MuJoCo would refuse, or would make something else of."""
    for entry, path, called in _contacts(case):
        condim = entry.get("condim", 3)
        if condim not in _CONDIMS:
            message = f"the condim of {called} is {number(condim)}"
            help = "write 1 (without friction), 3 (sliding), 4 (and spinning) or 6 (and rolling)"
            yield case.problem("contact-value", message, (*path, "condim"), help)
        for index, value in enumerate(entry.get("friction") or ()):
            if value < 0:
                message = f"the friction of {called} is {number(value)}, below zero"
                yield case.problem("contact-value", message, (*path, "friction", index), "write it without the sign")
        for key in ("margin", "gap", "solmix", "adhesion"):
            if entry.get(key, 0) < 0:
                message = f"the {key} of {called} is {number(entry[key])}, below zero"
                yield case.problem("contact-value", message, (*path, key), "write it without the sign")
        if path[0] == "contact_pairs" and ("links" in entry) == ("shapes" in entry):
            what = "links and shapes" if "links" in entry else "neither links nor shapes"
            yield case.problem("contact-value", f"{called} has {what}", path, "write links: [A, B] or shapes: [A, B]")
        both = entry.get("shapes") or entry.get("links") or (0, 1)
        if both[0] == both[1]:
            yield case.problem("contact-value", f'{called} is of "{both[0]}" with itself', path, "name two")


def _contacts(case: Case) -> Iterator[tuple[Mapping[str, Any], Path, str]]:
    for index, pair in enumerate(case.tree.get("contact_pairs") or ()):
        yield pair, ("contact_pairs", index), "a contact pair"
    for link in case.robot.links:
        for index, shape in enumerate(link.collision):
            if shape.contact is not None:
                path = case.link(link.name, "collision", index, "contact")
                yield at(case.tree, path), path, f'a shape of link "{link.name}"'


@rule(
    "contact-layer",
    "A contact names a layer that `contact_layers` does not list, that list names one twice, or there are more layers "
    "than MuJoCo has bits. A warning, where there is no list: no shape is on a layer that is to be touched, or a shape "
    "is on one that nothing touches, with a name like that of another one.",
    "Correct the name, or add it to the list.",
    Heading.SIMULATED,
)
def layers(case: Case) -> Iterator[Diagnostic]:
    """Layers of contacts that there are not, or too many of."""
    listed = case.robot.contact_layers
    for index, name in enumerate(listed):
        if name in listed[:index]:
            message = f'the layer "{name}" is listed twice'
            yield case.problem("contact-layer", message, ("contact_layers", index), "remove one")
    named: dict[str, Path] = {}
    for entry, path, _ in _contacts(case):
        for key in ("layers", "touches"):
            for index, name in enumerate(entry.get(key) or ()):
                named.setdefault(name, (*path, key, index))
    if len(listed) > MOST_LAYERS:
        message = f"there are {len(listed)} layers of contacts: MuJoCo has bits for {MOST_LAYERS}"
        yield case.problem("contact-layer", message, ("contact_layers",), "use fewer layers", key=True)
    for name, path in named.items() if listed else ():
        if name not in listed:
            message = f'there is no layer "{name}" of contacts'
            yield case.problem(
                "contact-layer", message, path, Suggestion(name, set(listed), "add it to contact_layers")
            )
    if not listed and len({*named, SHARED_LAYER}) > MOST_LAYERS:
        message = f"shapes name {len({*named, SHARED_LAYER})} layers of contacts: MuJoCo has bits for {MOST_LAYERS}"
        yield case.problem("contact-layer", message, next(iter(named.values())), "use fewer layers")
    if not listed:
        yield from _lonely(case)


def _lonely(case: Case) -> Iterator[Diagnostic]:
    """Yield layers that one side of contacts alone names; what says nothing of them has the shared one on both."""
    sides: dict[str, dict[str, Path]] = {"layers": {}, "touches": {}}
    inert: set[str] = set()
    for entry, path, _ in _contacts(case):
        for key, names in sides.items():
            for index, name in enumerate(entry.get(key) or ()):
                names.setdefault(name, (*path, key, index))
        inert |= {*(entry.get("layers") or ())} if entry.get("touches") == [] else set()
    for key, other in (("touches", "layers"), ("layers", "touches")):
        for name, path in sides[key].items():
            if name in sides[other] or name == SHARED_LAYER:
                continue
            what = "is on" if key == "touches" else "touches"
            otherwise = f'the floor and all that names no layer is on "{SHARED_LAYER}"'
            if key == "layers" and name in inert:
                otherwise = "write layers: [] where nothing is to find it"
            help = did_you_mean(name, {*sides[other], SHARED_LAYER}, otherwise)
            if key == "touches" or name in inert or help.startswith("did"):
                message = f'no shape {what} the layer "{name}" of contacts'
                yield case.problem("contact-layer", message, path, help, severity=WARNING)


# What a joint of each kind counts among the speeds.
_SPEEDS = {"planar": 3, "floating": 6, "ball": 3}
_PLACES = {"planar": 3, "floating": 7, "ball": 4}  # and how many positions
_FREE = 6


@rule(
    "key-length",
    "A pose lists positions, speeds, activations or places of motion capture for MuJoCo, and not as many as there are.",
    "Give one for each, in MuJoCo's order.",
    Heading.SIMULATED,
)
def keys(case: Case) -> Iterator[Diagnostic]:
    """Find lists of poses whose length MuJoCo would refuse."""
    if not any(pose.mjcf for pose in case.robot.poses):
        return
    moving = sum(_SPEEDS.get(joint.type, 1 if joint.moves else 0) for joint in case.robot.joints)
    captured = sum(link.mjcf.get("mocap") is True for link in case.robot.links)
    bases = [output.options.get("base", "fixed") for output in case.robot.outputs if output.backend == "mjcf"]
    lengths = {"mpos": {3 * captured}, "mquat": {4 * captured}}
    lengths["qvel"] = {moving + (_FREE if base == "free" else 0) for base in bases} or {moving, moving + _FREE}
    places = sum(_PLACES.get(joint.type, 1 if joint.moves else 0) for joint in case.robot.joints)
    lengths["qpos"] = {places + (_FREE + 1 if base == "free" else 0) for base in bases} or {places, places + _FREE + 1}
    if all(driver.actuator.type in _STATELESS for driver in drivers(case)) and not case.robot.mjcf_elements:
        lengths["act"] = {sum("timeconst" in driver.actuator.mjcf for driver in drivers(case))}
    for pose in case.robot.poses:
        for word, allowed in lengths.items():
            given = pose.mjcf.get(word)
            if isinstance(given, tuple) and (allowed != {len(given)} if bases else len(given) not in allowed):
                there = " or ".join(map(str, sorted(allowed)))
                message = f'pose "{pose.name}" has {counted(len(given), "number")} of {word}, and the robot {there}'
                path: Path = ("poses", pose.name, "mjcf", word)
                yield case.problem("key-length", message, path, "give one for each, in MuJoCo's order", key=True)


_STATELESS = ("position", "velocity", "motor", "damper", "adhesion")
