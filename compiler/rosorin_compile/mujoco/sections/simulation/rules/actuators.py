"""Whether actuators act on one thing, and have the words that MuJoCo knows of their type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.model import Joint
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.simulated import BALL, several
from rosorin_compile.source.diagnostics import Diagnostic, listed
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path

from ..lowering import TARGETS
from .unfit import unfit


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
    """An actuator, what it is called in a message, its path, and the joint that it stands with."""

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
    "An actuator acts on nothing, on two things, or on what its type cannot drive.",
    "Name one: a joint, a tendon, a site or a body.",
    Heading.SIMULATED,
)
def targets(case: Case) -> Iterator[Diagnostic]:
    """Actuators of the section that do not act on one thing."""
    for actuator in case.robot.actuators:
        path: Path = ("actuators", actuator.name)
        wrong = _target(actuator, several(case))
        if wrong:
            message, help = wrong
            yield case.problem("actuator-target", f'actuator "{actuator.name}" {message}', path, help, key=True)


def _target(actuator: Actuator, turning: Mapping[str, str]) -> tuple[str, str] | None:
    """Return what is wrong with what an actuator acts on, and the fix."""
    given, words = set(actuator.targets), {word: key for key, word in TARGETS.items()}
    if not given:
        return "acts on nothing", "name one: joint: NAME, tendon: NAME, site: NAME or body: NAME"
    needs = {"refsite": "site", "slidersite": "cranksite", "cranksite": "slidersite"}
    for word, other in needs.items():
        if word in given and other not in given:
            return f"has a {words[word]} and no {words[other]}", f"add {words[other]}: NAME"
    kinds = given - {"refsite", "slidersite"}
    if len(kinds) > 1:
        named = listed([words[word] for word in sorted(given)])
        return f"acts on several things: {named}", "leave one; write an actuator for each of the others"
    known = WORDS[actuator.type]
    if not given <= known:
        can = [word for word in TARGETS if TARGETS[word] in known]
        way = f"name a {' or '.join(can)}" if can else ""
        return f"is of type {actuator.type}, which drives no {words[min(given - known)]}", way
    if actuator.type == "orientation" and given == {"site"}:
        return "turns a site against nothing", "add reference_site: NAME"
    if actuator.type == "orientation" and "joint" in given and not given & {"site"}:
        return _ball(actuator, turning)
    if "cranksite" in given and not (_number(actuator, "cranklength") or 0.0) > 0:
        return "has a crank without a length", "write mjcf: {cranklength: ...}, in m"
    return None


def _ball(actuator: Actuator, turning: Mapping[str, str]) -> tuple[str, str] | None:
    name = actuator.targets["joint"]
    if turning.get(name) == BALL:
        return None
    return f'turns joint "{name}", which is no ball', "name a ball joint, or a site"


def _number(actuator: Actuator, word: str) -> float | None:
    value = actuator.mjcf.get(word)
    return float(value) if isinstance(value, (int, float)) else None


@rule(
    "actuator-word",
    "An actuator has a word that its type does not know, or lacks one that it needs: `position` needs `kp`, `velocity` "
    "needs `kv`.",
    "As the message says.",
    Heading.SIMULATED,
)
def words(case: Case) -> Iterator[Diagnostic]:
    """Actuators with words of another type, or without one that a simulation would invent."""
    for driver in drivers(case):
        actuator, called, path, joint = driver
        known = WORDS[actuator.type]
        for word, key in _said(actuator):
            if word not in known:
                others = [kind for kind in WORDS if word in WORDS[kind]]
                message = f"{called} is of type {actuator.type}, which has no {key[-1]}"
                help = f"leave it out, or take a type that has it: {', '.join(others)}"
                yield case.problem("actuator-word", message, (*path, *key), help, key=True)
        if joint is not None and not known & {"joint"}:
            message = f"{called} is of type {actuator.type}, which drives no joint"
            yield case.problem("actuator-target", message, (*path, "type"), "write it under actuators, with its target")
        yield from _lacking(case, driver)


def _said(actuator: Actuator) -> Iterator[tuple[str, Path]]:
    """Yield the words of MuJoCo that an actuator says, and the keys that say them."""
    values: dict[str, object] = {"kp": actuator.kp is not None, "kv": actuator.kv, "dampratio": actuator.damping_ratio}
    values |= {"gear": actuator.gear, "forcerange": actuator.force is not None}
    yield from ((word, (_OF_US[word],)) for word, said in values.items() if said)
    yield from ((word, ("mjcf", word)) for word in actuator.mjcf)


def _lacking(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    actuator, called, path, _ = driver
    kind = actuator.type
    word = _LACKING.get(kind, "")
    said = {"kp": actuator.kp is not None, "kv": bool(actuator.kv)}
    if word and not said[word]:
        message = f"{called} is of type {kind} and has no {word}: MuJoCo would take 1"
        yield case.problem("actuator-word", message, path, f"write {word}: ...", key=True)
    if actuator.damping_ratio and said["kv"]:
        message = f"{called} has kv and damping_ratio, two words for one damping"
        yield case.problem("actuator-word", message, (*path, "damping_ratio"), "leave one of them out", key=True)
    if "inheritrange" in actuator.mjcf:
        yield from _inherited(case, driver)
    elif kind in ("damper", "adhesion") and (actuator.range is None or actuator.unlimited):
        message = f"{called} is of type {kind} and has no range"
        place = (*path, "unlimited") if actuator.unlimited else path
        yield case.problem("actuator-word", message, place, "write range: [0, ...]", key=True)
    elif kind in ("damper", "adhesion") and actuator.range is not None and actuator.range[0] < 0:
        message = f"the range of {called} begins below zero, and it is of type {kind}"
        yield case.problem("actuator-word", message, (*path, "range"), "write range: [0, ...]")
    if kind == "dcmotor":
        yield from _motor(case, driver)
    if kind == "muscle" and actuator.gear and not actuator.gear[0] and "lengthrange" not in actuator.mjcf:
        message = f"{called} is of type muscle and has a gear of 0: its length never changes"
        help = "write another gear, or mjcf: {lengthrange: [..., ...]}"
        yield case.problem("actuator-word", message, (*path, "gear"), help, key=True)
    yield from _limited(case, driver)
    for word, message, help in unfit(actuator):
        yield case.problem("actuator-word", f"{called} {message}", (*path, "mjcf", word), help, key=True)


def _motor(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what a motor lacks of its constants."""
    values = driver.actuator.mjcf
    constants, nominal, resistance = (values.get(word) for word in ("motorconst", "nominal", "resistance"))
    if isinstance(nominal, tuple) and len(nominal) == 3 and all(float(value) > 0 for value in nominal):
        return
    turns = isinstance(constants, tuple) and all(float(one) >= 0 for one in constants) and any(constants)
    if not turns or not isinstance(resistance, float) or not resistance > 0:
        message = f"{driver.called} is of type dcmotor and lacks the constant or the resistance of its motor"
        help = "write mjcf: {motorconst: [...], resistance: ...}, or nominal: [VOLTAGE, STALL_TORQUE, NO_LOAD_SPEED]"
        yield case.problem("actuator-word", message, driver.path, help, key=True)


_LIMITED = {"ctrllimited": "range", "forcelimited": "force", "actlimited": "actrange"}


def _limited(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what says that a range holds, or a delay, and has none."""
    actuator, called, path, joint = driver
    has = {
        "range": actuator.range is not None or "posrange" in actuator.mjcf or "inheritrange" in actuator.mjcf
        or (joint is not None and not actuator.unlimited and joint.limit is not None),
        "force": actuator.force is not None,
        "actrange": "actrange" in actuator.mjcf or "inheritrange" in actuator.mjcf,
    }  # fmt: skip
    for word, other in _LIMITED.items():
        if actuator.mjcf.get(word) is True and not has[other]:
            message = f"{called} is {word} and has no {other}"
            yield case.problem("actuator-word", message, (*path, "mjcf", word), f"write {other}: [..., ...]", key=True)
    if (_number(actuator, "delay") or 0.0) > 0 and not (_number(actuator, "nsample") or 0.0) > 0:
        message = f"{called} has a delay and no samples to take it from"
        yield case.problem("actuator-word", message, (*path, "mjcf", "delay"), "write nsample: 2, or more", key=True)


def _inherited(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what keeps an actuator from the range of what it drives."""
    actuator, called, path, joint = driver
    place = (*path, "mjcf", "inheritrange")
    kinds = set(actuator.targets) or {"joint"}
    other = "range" if actuator.range is not None else "actrange" if "actrange" in actuator.mjcf else ""
    target = joint or case.robot.joint.get(actuator.targets.get("joint", ""))
    limit = target.limit if target is not None and target.type != "continuous" else None
    has = limit is not None and limit.lower is not None and limit.upper is not None
    has = has or "tendon" in kinds  # whose element may have one
    if other:
        message = f"{called} has {other} and inheritrange, two words for one range"
        yield case.problem("actuator-word", message, place, "leave one of them out", key=True)
    elif not kinds <= {"joint", "tendon"} or not has:
        message = f"{called} takes over a range, but what it drives has none"
        yield case.problem("actuator-word", message, place, "write range: [..., ...]", key=True)
