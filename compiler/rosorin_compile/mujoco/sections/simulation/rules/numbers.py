"""Numbers of what only a simulation has: ranges with room, and contacts that MuJoCo accepts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import Diagnostic, counted
from rosorin_compile.source.rule_registry import Check, Heading, rule
from rosorin_compile.source.tree import Path, at

from .actuators import drivers

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
    """Ranges of actuators and joints in which nothing lies."""
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


def _contacts(case: Case) -> Iterator[tuple[Mapping[str, Any], Path, str]]:
    for link in case.robot.links:
        for index, shape in enumerate(link.collision):
            if shape.contact is not None:
                path = case.link(link.name, "collision", index, "contact")
                yield at(case.tree, path), path, f'a shape of link "{link.name}"'


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
    if all(driver.actuator.type in _STATELESS for driver in drivers(case)) and not case.robot.mjcf:
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
