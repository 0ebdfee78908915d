"""The section ``actuators``: they act on one thing, and have the words and numbers that MuJoCo takes of their type.

Found by giving MuJoCo 4.0 every word of every type: what it refuses is reported here at its line.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.language.records import Problem, entries_of, record_of
from rosorin_compile.model import Joint
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator, Attribute
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.simulated import BALL, several
from rosorin_compile.source.diagnostics import Diagnostic, listed
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
Wrong = tuple[str, str, str]  # the key, what is wrong, what to do
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
    "An actuator acts on nothing, on several things, or on what its type cannot drive.",
    "Name one: a joint, a tendon, a site or a body.",
    SIMULATED,
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
    given, words = set(actuator.targets), {word: key for key, word in TARGETS.items()}
    if not given:
        return "acts on nothing", "name one: joint: NAME, tendon: NAME, site: NAME or body: NAME"
    for word, other in (("refsite", "site"), ("slidersite", "cranksite"), ("cranksite", "slidersite")):
        if word in given and other not in given:
            return f"has a {words[word]} and no {words[other]}", f"add {words[other]}: NAME"
    if len(given - {"refsite", "slidersite"}) > 1:
        named = listed([words[word] for word in sorted(given)])
        return f"acts on several things: {named}", "leave one; write an actuator for each of the others"
    known = WORDS[actuator.type]
    if not given <= known:
        can = [key for key, word in TARGETS.items() if word in known]
        way = f"name a {' or '.join(can)}" if can else ""
        return f"is of type {actuator.type}, which drives no {words[min(given - known)]}", way
    if actuator.type == "orientation" and given == {"site"}:
        return "turns a site against nothing", "add reference_site: NAME"
    if actuator.type == "orientation" and "joint" in given and turning.get(actuator.targets["joint"]) != BALL:
        return f'turns joint "{actuator.targets["joint"]}", which is no ball', "name a ball joint, or a site"
    if "cranksite" in given and not (_number(actuator, "cranklength") or 0.0) > 0:
        return "has a crank without a length", "write mjcf: {cranklength: ...}, in m"
    return None


def _number(actuator: Actuator, word: str) -> float | None:
    value = actuator.mjcf.get(word)
    return float(value) if isinstance(value, (int, float)) else None


@rule(
    "actuator-word",
    "An actuator has a key that its type does not know, or lacks one: `position` needs `kp`, `velocity` needs `kv`.",
    "See the message.",
    SIMULATED,
)
def words(case: Case) -> Iterator[Diagnostic]:
    """Actuators with words of another type, or without one that a simulation would invent."""
    for actuator, called, path, joint in drivers(case):
        known, kind = WORDS[actuator.type], actuator.type
        values: dict[str, object] = {"kp": actuator.kp is not None, "kv": actuator.kv}
        values |= {"dampratio": actuator.damping_ratio, "gear": actuator.gear, "forcerange": actuator.force is not None}
        said: list[tuple[str, Path]] = [(word, (_OF_US[word],)) for word, value in values.items() if value]
        for word, key in (*said, *((word, ("mjcf", word)) for word in actuator.mjcf)):
            if word not in known:
                others = ", ".join(other for other in WORDS if word in WORDS[other])
                message = f"{called} is of type {kind}, which has no {key[-1]}"
                help = f"leave it out, or take a type that has it: {others}"
                yield case.problem("actuator-word", message, (*path, *key), help, key=True)
        if joint is not None and not known & {"joint"}:
            message = f"{called} is of type {kind}, which drives no joint"
            yield case.problem("actuator-target", message, (*path, "type"), "write it under actuators, with its target")
        lacking = (*_lacking(actuator), *_ranges(case, actuator, joint), *unfit(actuator))
        for place, message, help in lacking:
            inner: Path = () if not place else ("mjcf", place) if place not in _OWN else (place,)
            yield case.problem("actuator-word", f"{called} {message}", (*path, *inner), help, key=place != "range")


_OWN = ("damping_ratio", "gear", "range", "unlimited")


def _lacking(actuator: Actuator) -> Iterator[Wrong]:
    kind, values = actuator.type, actuator.mjcf
    word = _LACKING.get(kind, "")
    if word and not (actuator.kp is not None if word == "kp" else actuator.kv):
        yield "", f"is of type {kind} and has no {word}: MuJoCo would take 1", f"write {word}: ..."
    if actuator.damping_ratio and actuator.kv:
        yield "damping_ratio", "has kv and damping_ratio, two words for one damping", "leave one of them out"
    if kind == "dcmotor":
        words = ("motorconst", "nominal", "resistance")
        constants, nominal, resistance = (_numbers(values.get(word)) for word in words)
        is_rated = len(nominal) == 3 and min(nominal) > 0
        is_turning = any(constants) and min(constants) >= 0 and any(one > 0 for one in resistance)
        if not is_rated and not is_turning:
            help = "write mjcf: {motorconst: [...], resistance: ...}"
            help += ", or nominal: [VOLTAGE, STALL_TORQUE, NO_LOAD_SPEED]"
            yield "", "is of type dcmotor and lacks the constant or the resistance of its motor", help
    if kind == "muscle" and actuator.gear and not actuator.gear[0] and "lengthrange" not in values:
        help = "write another gear, or mjcf: {lengthrange: [..., ...]}"
        yield "gear", "is of type muscle and has a gear of 0: its length never changes", help
    if (_number(actuator, "delay") or 0.0) > 0 and not (_number(actuator, "nsample") or 0.0) > 0:
        yield "delay", "has a delay and no samples to take it from", "write nsample: 2, or more"


def _ranges(case: Case, actuator: Actuator, joint: Joint | None) -> Iterator[Wrong]:
    kind, values, inherits = actuator.type, actuator.mjcf, "inheritrange" in actuator.mjcf
    if inherits:
        kinds = set(actuator.targets) or {"joint"}
        other = "range" if actuator.range is not None else "actrange" if "actrange" in values else ""
        target = joint or case.robot.joint.get(actuator.targets.get("joint", ""))
        limit = target.limit if target is not None and target.type != "continuous" else None
        has = limit is not None and limit.lower is not None and limit.upper is not None
        if other:
            yield "inheritrange", f"has {other} and inheritrange, two words for one range", "leave one of them out"
        elif not kinds <= {"joint", "tendon"} or not (has or "tendon" in kinds):  # whose element may have one
            yield "inheritrange", "takes over a range, but what it drives has none", "write range: [..., ...]"
    elif kind in ("damper", "adhesion") and (actuator.range is None or actuator.unlimited):
        yield "unlimited" if actuator.unlimited else "", f"is of type {kind} and has no range", "write range: [0, ...]"
    elif kind in ("damper", "adhesion") and actuator.range is not None and actuator.range[0] < 0:
        yield "range", f"is of type {kind}, and its range begins below zero", "write range: [0, ...]"
    of_joint = joint is not None and not actuator.unlimited and joint.limit is not None
    limited = (
        ("ctrllimited", "range", actuator.range is not None or "posrange" in values or inherits or of_joint),
        ("forcelimited", "force", actuator.force is not None),
        ("actlimited", "actrange", "actrange" in values or inherits),
    )
    for word, other, is_there in limited:
        if values.get(word) is True and not is_there:
            yield word, f"is {word} and has no {other}", f"write {other}: [..., ...]"


# The inputs of each type, in MuJoCo's order.
_INPUTS = {
    "orientation": ("expmap", "quat"),
    "pid": ("pos", "vel", "ff"),
    "dcmotor": ("pos", "vel", "ff", "voltage", "none"),
    "general": ("pos", "vel", "ff", "voltage", "pressure", "none", "expmap", "quat"),
}
_ONE_INPUT = ("pos", "vel", "pressure", "expmap")  # of a gain that is fixed or affine
# Numbers that may not be below zero, by type.
_SIZES = {"pid": ("slewmax",), "adhesion": ("gain",), "dcmotor": ("motorconst", "resistance", "inductance")}
_MUSCLE = ("scale", "vmax", "fpmax", "fvmax")  # may not be zero
_OF_PID = ("ki", "slewmax")  # need the input pos


def unfit(actuator: Actuator) -> Iterator[Wrong]:
    """Yield attributes that MuJoCo takes of a type only with others, or in another form."""
    values, targets, kind = actuator.mjcf, set(actuator.targets), actuator.type
    inputs, legal = str(values.get("input", "")).split(), _INPUTS.get(kind, ())
    if "cranklength" in values and "cranksite" not in targets:
        yield "cranklength", "has a cranklength and no crank", "write slider_site and crank_site, or leave it out"
    if targets and not targets & {"joint", "tendon", "jointinparent"}:
        for word in ("damping", "armature"):
            if word in values:
                yield word, f"has {word}, which only joints and tendons take", "leave it out"
    if inputs != [one for one in legal if one in inputs]:
        yield "input", f'has an input "{" ".join(inputs)}"', f"write some of: {' '.join(legal)}, in this order"
    times, count = _numbers(values.get("timeconst")), 2 if kind == "muscle" else 1
    if times and (len(times) != count or (count == 1 and times[0] < 0)):
        yield "timeconst", "has a time constant below zero, or several", f"write {count} not below zero"
    sizes = _SIZES.get(kind, ())
    if kind == "pid" and any(_numbers(values.get("ki"))):
        sizes = (*sizes, "imax") if any(_numbers(values.get("slewmax"))) else (*sizes, "ki", "imax")
    for word in sizes:
        if min(_numbers(values.get(word)), default=0) < 0:
            yield word, f"has {word} below zero", "write it without the sign"
    for word in _MUSCLE if kind == "muscle" else ():
        if 0 in _numbers(values.get(word)):
            yield word, f"has {word} zero", "write a number above zero, or leave it out"
    for word in _OF_PID if kind == "pid" and inputs and "pos" not in inputs else ():
        if any(_numbers(values.get(word))):
            help = f'write input: "{" ".join(["pos", *inputs])}", or leave it out'
            yield word, f"has {word} and no input pos", help
    if kind == "dcmotor":
        gains, thermal = (_numbers(values.get(word)) for word in ("controller", "thermal"))
        if any(gains[:4]) and not {"pos", "vel", "ff"} & {*inputs}:
            help = 'write input: "pos", or some of: pos vel ff'
            yield "controller", "has gains of a controller and no input for it", help
        elif any(gains[1:2]) and "pos" not in inputs:
            help = f'write input: "{" ".join(["pos", *inputs])}"'
            yield "controller", "has an integral gain and no input pos", help
        if any(thermal) and not (len(thermal) > 1 and min(thermal[:2]) > 0):
            help = "write both: [RESISTANCE, CAPACITANCE]"
            yield "thermal", "has no thermal resistance and capacitance above zero", help
    if kind == "general":
        yield from _general(values, inputs)


def _general(values: Mapping[str, Attribute], inputs: Sequence[str]) -> Iterator[Wrong]:
    """Yield what a general actuator has of one type and lacks to be of it."""
    dynamics, gain, bias = (str(values.get(word, "")) for word in ("dyntype", "gaintype", "biastype"))
    gains, biases = (_numbers(values.get(word)) for word in ("gainprm", "biasprm"))
    is_half_gain = gain == "pid" and (bias != "affine" or (gains[:1] != (0,) and dynamics != "pid"))
    if is_half_gain or (dynamics == "pid" and gain != "pid"):
        help = "write dyntype: pid, gaintype: pid and biastype: affine, or take the type pid"
        yield "gaintype" if gain == "pid" else "dyntype", "is a pid in parts", help
    if gain == bias == "so3" and (*gains, 1.0)[0] != -(*biases[1:2], 0.0)[0]:
        help = "write gainprm: [KP] and biasprm: [0, -KP]"
        yield "gaintype", "is so3 and has another gain than bias", help
    for word, numbers in (("gaintype", gains), ("biastype", biases)):
        # The range of a muscle, and scale, vmax, fpmax and fvmax above zero.
        is_muscle = len(numbers) > 8 and numbers[0] < numbers[1] and min(numbers[3], *numbers[6:9]) > 0
        if values.get(word) == "muscle" and not is_muscle:
            message = f"is a muscle without its numbers in {word[:4]}prm"
            yield word, message, "write them, or take the type muscle"
    if inputs and gain in ("muscle", "user"):
        yield "input", f"has an input and a gain of type {gain}", "leave it out"
    elif inputs and gain in ("", "fixed", "affine") and " ".join(inputs) not in _ONE_INPUT:
        yield "input", f"has an input {' '.join(inputs)}", "write one of: pos, vel, pressure"


def _numbers(value: Attribute) -> tuple[float, ...]:
    if isinstance(value, tuple):
        return tuple(map(float, value))
    return (value,) if isinstance(value, float) else ()


# The rules of numbers are about joints, contacts of shapes and constraints as well.
SECTION: Section[Any] = Section("actuators", Actuator, lower=_actuators, checks=(__name__, f"{__name__}.numbers"))
