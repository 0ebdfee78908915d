"""The section ``actuators``: they act on one thing, and have the attributes that MuJoCo knows of their type.

Numbers that do not fit together are left to MuJoCo, which refuses to load the MJCF.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rosorin_compile.language.lower import Problem, entries_of, record_of
from rosorin_compile.model import Joint
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic, phrase
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.tree import Path

TARGETS = {
    "joint": "joint",
    "joint_in_parent": "jointinparent",
    "tendon": "tendon",
    "site": "site",
    "reference_site": "refsite",
    "slider_site": "slidersite",
    "crank_site": "cranksite",
    "body": "body",
}
"""What an actuator acts on: the word of the language, and that of MuJoCo."""


def _actuators(tree: Mapping[str, Any], _: Problem) -> tuple[Actuator, ...]:
    made = []
    for name, entry in entries_of(tree, "actuators"):
        targets = {word: entry[key] for key, word in TARGETS.items() if key in entry}
        made.append(record_of(Actuator, entry, name=name, targets=targets))
    return tuple(made)


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


# Words of all actuators, and of those that drive by a transmission.
_ALL = _set("name group nsample interp delay ctrlrange user")
_DRIVEN = _ALL | _set(
    "ctrllimited forcelimited forcerange lengthrange gear damping armature cranklength joint jointinparent tendon"
    " slidersite cranksite site refsite"
)
_GENERAL = "actlimited actrange actdim input velrange ffrange inheritrange dyntype gaintype biastype dynprm gainprm"


def _and(words: str, without: str = "") -> frozenset[str]:
    return (_DRIVEN | _set(words)) - _set(without)


WORDS: Mapping[str, frozenset[str]] = {
    "general": _and(f"body biasprm actearly {_GENERAL}"),
    "motor": _DRIVEN,
    "position": _and("inheritrange kp kv dampratio timeconst"),
    "velocity": _and("kv"),
    "intvelocity": _and("actlimited actrange inheritrange kp kv dampratio"),
    "orientation": _ALL | _set("forcelimited forcerange joint site refsite kp kv dampratio input"),
    "pid": _and("posrange velrange ffrange inheritrange kp kv dampratio ki imax slewmax input"),
    "damper": _and("kv", "ctrllimited"),
    "cylinder": _and("timeconst area diameter bias"),
    "muscle": _and("timeconst tausmooth range force scale lmin lmax vmax fpmax fvmax", "site refsite"),
    "adhesion": _ALL | _set("forcelimited forcerange body gain"),
    "dcmotor": _and(
        "motorconst resistance nominal saturation inductance cogging controller thermal lugre input",
        "forcelimited forcerange",
    ),
}
"""The attributes that MuJoCo knows of each type of actuators."""

_OF_US = {"kp": "kp", "kv": "kv", "dampratio": "damping_ratio", "gear": "gear", "forcerange": "force"}
_LACKING = {"position": "kp", "velocity": "kv", "damper": "kv", "intvelocity": "kp", "orientation": "kp", "pid": "kp"}


class Driver(NamedTuple):
    """An actuator, its name in messages, its path, and the joint whose entry it is part of."""

    actuator: Actuator
    called: str
    path: Path
    joint: Joint | None


def drivers(case: Case) -> Iterator[Driver]:
    """Yield every actuator of a robot: those of joints that move, and those of the section."""
    for joint in case.robot.joints:
        if joint.actuator is not None and joint.moves:
            yield Driver(joint.actuator, f'the actuator of joint "{joint.name}"', case.joint(joint, "actuator"), joint)
    for actuator in case.robot.actuators:
        yield Driver(actuator, f'actuator "{actuator.name}"', ("actuators", actuator.name), None)


@rule(
    "actuator-target",
    "An actuator acts on nothing, on several things, or on what its type cannot drive.",
    "Name one: a joint, a tendon, a site or a body.",
    SIMULATED,
)
def targets(case: Case) -> Iterator[Diagnostic]:
    """Actuators of the section that do not act on one thing."""
    for actuator in case.robot.actuators:
        path: Path = ("actuators", actuator.name)
        wrong = _target(actuator)
        if wrong:
            message, help = wrong
            yield case.problem("actuator-target", f'actuator "{actuator.name}" {message}', path, help, key=True)


def _target(actuator: Actuator) -> tuple[str, str] | None:
    used, words = set(actuator.targets), {word: key for key, word in TARGETS.items()}
    if not used:
        return "acts on nothing", "name one: joint: NAME, tendon: NAME, site: NAME or body: NAME"
    for word, required in (("refsite", "site"), ("slidersite", "cranksite"), ("cranksite", "slidersite")):
        if word in used and required not in used:
            return f"has a {words[word]} and no {words[required]}", f"add {words[required]}: NAME"
    if len(used - {"refsite", "slidersite"}) > 1:
        named = phrase([words[word] for word in sorted(used)])
        return f"acts on several things: {named}", "leave one; write an actuator for each of the others"
    allowed = WORDS[actuator.type]
    if not used <= allowed:
        can = [key for key, word in TARGETS.items() if word in allowed]
        help = f"name a {' or '.join(can)}" if can else ""
        return f"is of type {actuator.type}, which drives no {words[min(used - allowed)]}", help
    return None


@rule(
    "actuator-word",
    "An actuator has a key that its type does not know, or lacks one: `position` needs `kp`, `velocity` needs `kv`.",
    "Remove the key, choose another type, or add the gain.",
    SIMULATED,
)
def words(case: Case) -> Iterator[Diagnostic]:
    """Actuators with words of another type, or without a gain that MuJoCo would take for 1."""
    for actuator, called, path, joint in drivers(case):
        allowed, kind = WORDS[actuator.type], actuator.type
        values: dict[str, object] = {"kp": actuator.kp is not None, "kv": actuator.kv}
        values |= {"dampratio": actuator.damping_ratio, "gear": actuator.gear, "forcerange": actuator.force is not None}
        used: list[tuple[str, Path]] = [(word, (_OF_US[word],)) for word, value in values.items() if value]
        for word, key in (*used, *((word, ("mjcf", word)) for word in actuator.mjcf)):
            if word not in allowed:
                types = ", ".join(name for name in WORDS if word in WORDS[name])
                message = f"{called} is of type {kind}, which has no {key[-1]}"
                help = f"leave it out, or use a type that has it: {types}"
                yield case.problem("actuator-word", message, (*path, *key), help, key=True)
        if joint is not None and "joint" not in allowed:
            message = f"{called} is of type {kind}, which drives no joint"
            yield case.problem("actuator-target", message, (*path, "type"), "write it under actuators, with its target")
        gain = _LACKING.get(kind, "")
        if gain and not values[gain]:
            message = f"{called} is of type {kind} and has no {gain}: MuJoCo would use 1"
            yield case.problem("actuator-word", message, path, f"write {gain}: ...", key=True)
        if actuator.damping_ratio and actuator.kv:
            message = f"{called} has kv and damping_ratio, two words for one damping"
            yield case.problem("actuator-word", message, (*path, "damping_ratio"), "leave one of them out", key=True)


# The rules of numbers are about joints, contacts of shapes and constraints as well.
SECTION: Section[Any] = Section("actuators", Actuator, lower=_actuators, checks=(__name__, f"{__name__}.numbers"))
