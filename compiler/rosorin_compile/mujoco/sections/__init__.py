"""The sections ``actuators``, ``constraints`` and ``mjcf``, and rules about simulation values.

Keys become attributes of MuJoCo elements, with references (links, joints, sites) unchanged. The schema of each section
is in its folder. An actuator has one target and the attributes that MuJoCo allows for its type. MuJoCo itself checks
whether the numbers are consistent when it loads the MJCF.
"""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any, NamedTuple

from rosorin_compile.language.lower import Problem, entries_of, pose_of_entry, record_of, renamed_values
from rosorin_compile.model import Joint
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator, Attribute, Entry
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import Diagnostic, count_of, phrase
from rosorin_compile.source.rule_registry import SIMULATED, Check, rule
from rosorin_compile.source.tree import Path, value_at

from .element_rules import multi_dof_joints

TARGETS = {"joint": "joint", "joint_in_parent": "jointinparent", "tendon": "tendon", "site": "site"}
TARGETS |= {"reference_site": "refsite", "slider_site": "slidersite", "crank_site": "cranksite", "body": "body"}
"""MuJoCo's attribute for each key that can be the target of an actuator."""


def _actuators(tree: Mapping[str, Any], _: Problem) -> tuple[Actuator, ...]:
    made = []
    for name, entry in entries_of(tree, "actuators"):
        targets = {word: entry[key] for key, word in TARGETS.items() if key in entry}
        made.append(record_of(Actuator, entry, name=name, targets=targets))
    return tuple(made)


_OF_CONSTRAINT = {"torque_scale": "torquescale", "polynomial": "polycoef", "active": "active"}
_OF_CONSTRAINT |= {"solref": "solref", "solimp": "solimp", "at": "anchor"}


def _constraints(tree: Mapping[str, Any], _: Problem) -> tuple[Entry, ...]:
    made = []
    for name, entry in entries_of(tree, "constraints"):
        values: dict[str, Attribute] = {}
        for key, word in (("links", "body"), ("sites", "site"), ("joints", "joint")):
            values |= {f"{word}{number}": one for number, one in enumerate(entry.get(key) or (), 1)}
        if "xyz" in entry or "rpy" in entry:
            pose = pose_of_entry(entry)
            values["relpose"] = (*pose.xyz, *pose.transform().quaternion())
        made.append(Entry(entry["type"], name, values | renamed_values(entry, _OF_CONSTRAINT)))
    return tuple(made)


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


# Attributes of all actuators, and of actuators with a transmission.
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
"""The attributes that MuJoCo allows for each type of actuator."""

_OF_US = {"kp": "kp", "kv": "kv", "dampratio": "damping_ratio", "gear": "gear", "forcerange": "force"}
_LACKING = {"position": "kp", "velocity": "kv", "damper": "kv", "intvelocity": "kp", "orientation": "kp", "pid": "kp"}


class Driver(NamedTuple):
    """An actuator, its name in messages and its path; ``joint`` is the joint whose entry defines it, or None."""

    actuator: Actuator
    called: str
    path: Path
    joint: Joint | None


def drivers(case: Case) -> Iterator[Driver]:
    """Yield the actuators of moving joints, then the actuators in the section ``actuators``."""
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
    """Report actuators without exactly one valid target."""
    for actuator in case.robot.actuators:
        if wrong := _target(actuator):
            path: Path = ("actuators", actuator.name)
            yield case.problem("actuator-target", f'actuator "{actuator.name}" {wrong[0]}', path, wrong[1], key=True)


def _target(actuator: Actuator) -> tuple[str, str] | None:
    used, words = set(actuator.targets), {word: key for key, word in TARGETS.items()}
    if not used:
        return "has no target", 'add one of "joint: NAME", "tendon: NAME", "site: NAME" or "body: NAME"'
    for word, required in (("refsite", "site"), ("slidersite", "cranksite"), ("cranksite", "slidersite")):
        if word in used and required not in used:
            return f"has a {words[word]} but no {words[required]}", f'add "{words[required]}: NAME"'
    if len(used - {"refsite", "slidersite"}) > 1:
        named = phrase([words[word] for word in sorted(used)])
        return f"has more than one target: {named}", "keep one target, and add an actuator for each of the others"
    wrong = used - WORDS[actuator.type]
    can = [key for key, word in TARGETS.items() if word in WORDS[actuator.type]]
    help = f"use one of these as the target: {', '.join(can)}" if can else ""
    return (f"is of type {actuator.type}, which cannot act on a {words[min(wrong)]}", help) if wrong else None


@rule(
    "actuator-word",
    "An actuator has a key that its type does not know, or lacks one: `position` needs `kp`, `velocity` needs `kv`.",
    "Remove the key, choose another type, or add the gain.",
    SIMULATED,
)
def words(case: Case) -> Iterator[Diagnostic]:
    """Report actuator keys that the type does not allow, and missing gains, for which MuJoCo would use 1."""
    for actuator, called, path, joint in drivers(case):
        kind, of_type = actuator.type, f"{called} is of type {actuator.type}"
        values: dict[str, object] = {"kp": actuator.kp is not None, "kv": actuator.kv}
        values |= {"dampratio": actuator.damping_ratio, "gear": actuator.gear, "forcerange": actuator.force is not None}
        used: list[tuple[str, Path]] = [(word, (_OF_US[word],)) for word, value in values.items() if value]
        for word, key in (*used, *((word, ("mjcf", word)) for word in actuator.mjcf)):
            if word not in WORDS[kind]:
                types = ", ".join(name for name in WORDS if word in WORDS[name])
                help, place = f"remove the key, or use a type that has it: {types}", (*path, *key)
                yield case.problem("actuator-word", f"{of_type}, which has no {key[-1]}", place, help, key=True)
        if joint is not None and "joint" not in WORDS[kind]:
            message, help = f"{of_type}, which cannot drive a joint", 'write it in "actuators", with its target'
            yield case.problem("actuator-target", message, (*path, "type"), help)
        if (gain := _LACKING.get(kind, "")) and not values[gain]:
            message = f"{of_type} but has no {gain}, for which MuJoCo would use 1"
            yield case.problem("actuator-word", message, path, f'add "{gain}: NUMBER"', key=True)
        if actuator.damping_ratio and actuator.kv:
            message = f"{called} has kv and damping_ratio, two keys for the same damping"
            yield case.problem("actuator-word", message, (*path, "damping_ratio"), "remove one of these keys", key=True)


# Keys and attributes with a lower and an upper value.
_RANGES = ("range", "force", "actrange", "lengthrange", "velrange", "ffrange", "posrange", "actuatorfrcrange")
_SIZES = ("damping", "friction", "armature", "stiffness", "kp", "kv", "damping_ratio")


@rule(
    "range-without-room",
    "A range for a simulation is empty: its first number is not below its second.",
    "Write the smaller number first, or remove the range.",
    SIMULATED,
)
def ranges(case: Case) -> Iterator[Diagnostic]:
    """Report empty ranges of actuators and joints."""
    for (entry, path, called), key in product(_entries(case), _RANGES):
        for ends, place in ((entry.get(key), path), ((entry.get("mjcf") or {}).get(key), (*path, "mjcf"))):
            if isinstance(ends, list) and len(ends) == 2 and not ends[0] < ends[1]:
                name = f'"{key}" range' if key == "force" else key
                message = f"the {name} of {called} is empty: it goes from {number(ends[0])} to {number(ends[1])}"
                help = f'write the smaller number first in "{key}"'
                help = help if ends[0] > ends[1] else f'write a maximum above the minimum, or remove "{key}"'
                yield case.problem("range-without-room", message, (*place, key), help)


def _entries(case: Case) -> Iterator[tuple[Mapping[str, Any], Path, str]]:
    yield from ((value_at(case.tree, driver.path), driver.path, driver.called) for driver in drivers(case))
    for name, entry in (case.tree.get("joints") or {}).items():
        if entry.get("mjcf"):
            yield {"mjcf": entry["mjcf"]}, ("joints", name), f'joint "{name}"'
    if case.tree.get("root"):
        yield case.tree["root"], ("root",), "the root"


@Check
def negative(case: Case) -> Iterator[Diagnostic]:
    """Report negative values of actuators and the root, and those values of joints that no other rule checks."""
    for (entry, path, called), key in product(_entries(case), _SIZES):
        value, is_in_joint = entry.get(key, 0.0), path[0] == "joints" and len(path) > 2
        if isinstance(value, (int, float)) and value < 0 and (key == "damping_ratio" or not is_in_joint):
            message = f"the {key} of {called} is {number(value)}, below zero"
            yield case.problem("dynamics-negative", message, (*path, key), "remove the minus sign")


@rule(
    "contact-value",
    "A contact has an impossible number: `condim` is 1, 3, 4 or 6; friction and margins are not negative.",
    "Use one of 1, 3, 4 and 6, or a number that is not negative.",
    SIMULATED,
)
def contacts(case: Case) -> Iterator[Diagnostic]:
    """Report contact values that MuJoCo would reject or misinterpret."""
    shapes = ((link.name, index) for link in case.robot.links for index, it in enumerate(link.collision) if it.contact)
    for link, index in shapes:
        path, called = case.link(link, "collision", index, "contact"), f'a shape of link "{link}"'
        entry = value_at(case.tree, path)
        if entry.get("condim", 3) not in (1, 3, 4, 6):
            message = f"the condim of {called} is {number(entry['condim'])}"
            help = "write 1 (without friction), 3 (sliding), 4 (and spinning) or 6 (and rolling)"
            yield case.problem("contact-value", message, (*path, "condim"), help)
        values: list[tuple[Path, Any]] = [(("friction", n), one) for n, one in enumerate(entry.get("friction") or ())]
        values += [((key,), entry.get(key, 0)) for key in ("margin", "gap", "solmix", "adhesion")]
        for key, value in values:
            if value < 0:
                message = f"the {key[0]} of {called} is {number(value)}, below zero"
                yield case.problem("contact-value", message, (*path, *key), "remove the minus sign")


# Lengths of qvel and qpos for joints with several coordinates, and for a free base.
_LENGTHS = {"qvel": {"planar": 3, "floating": 6, "ball": 3}, "qpos": {"planar": 3, "floating": 7, "ball": 4}}
_STATELESS = ("position", "velocity", "motor", "damper", "adhesion")


@rule(
    "key-length",
    "A pose lists too many or too few positions, speeds, activations or mocap poses for MuJoCo.",
    "Give one for each, in MuJoCo's order.",
    SIMULATED,
)
def keys(case: Case) -> Iterator[Diagnostic]:
    """Report poses with a list of positions, speeds or activations that has the wrong length for MuJoCo."""
    if not case.robot.poses:
        return
    joints, captured = case.robot.joints, sum(link.mjcf.get("mocap") is True for link in case.robot.links)
    bases = {one.options.get("base", "fixed") == "free" for one in case.robot.outputs if one.backend == "mjcf"}
    lengths = {"mpos": {3 * captured}, "mquat": {4 * captured}}
    for word, sizes in _LENGTHS.items():
        moving = sum(sizes.get(joint.type, 1 if joint.moves else 0) for joint in joints)
        lengths[word] = {moving + sizes["floating"] * is_free for is_free in bases or (False, True)}
    if all(driver.actuator.type in _STATELESS for driver in drivers(case)) and not case.robot.mjcf:
        lengths["act"] = {sum("timeconst" in driver.actuator.mjcf for driver in drivers(case))}
    for pose in case.robot.poses:
        for word, allowed in lengths.items():
            values = pose.mjcf.get(word)
            if isinstance(values, tuple) and ((bases and len(allowed) > 1) or len(values) not in allowed):
                expected, count = " or ".join(map(str, sorted(allowed))), count_of(len(values), "number")
                message = f'pose "{pose.name}" has {count} in "{word}", but MuJoCo expects {expected}'
                help = "list one value for each coordinate, in MuJoCo's order" if any(allowed) else f'remove "{word}"'
                yield case.problem("key-length", message, ("poses", pose.name, "mjcf", word), help, key=True)


# Keys with the objects that each type of constraint connects, and its other keys.
_ENDS = {"connect": ("links", "sites"), "weld": ("links", "sites"), "joint": ("joints",)}
_KEYS = {"connect": ("at",), "weld": ("at", "xyz", "rpy", "torque_scale"), "joint": ("polynomial",)}


@rule(
    "constraint-ends",
    "A constraint lacks what its type needs: `connect` two links and a point `at`, or two sites; `weld` two links or "
    "two sites; `joint` joints.",
    "Give it what its type needs, and nothing else.",
    SIMULATED,
)
def constraints(case: Case) -> Iterator[Diagnostic]:
    """Report constraints that MuJoCo would reject."""
    turning = multi_dof_joints(case)
    for name, entry in (case.tree.get("constraints") or {}).items():
        for index, joint in enumerate(entry.get("joints") or ()):
            if joint in turning:
                message = f'constraint "{name}" holds joint "{joint}", which is {turning[joint]}'
                help = "name joints with one position each"
                yield case.problem("constraint-ends", message, ("constraints", name, "joints", index), help)
        if wrong := _wrong_constraint(entry):
            message, help, *key = wrong
            path: Path = ("constraints", name, *key)
            yield case.problem("constraint-ends", f'constraint "{name}" {message}', path, help, key=True)


def _wrong_constraint(entry: Mapping[str, object]) -> tuple[str, ...] | None:
    """Return (message, help) or (message, help, key) for the first error in a constraint, or None."""
    kind = str(entry["type"])
    ends = [key for key in _ENDS[kind] if key in entry]
    known = (*_ENDS[kind], *_KEYS[kind], "type", "active", "solref", "solimp", "source")
    if extra := next((key for key in entry if key not in known), ""):
        return f"is of type {kind}, which has no {extra}", f'remove "{extra}", or correct the type', extra
    if not ends:
        return f"is of type {kind} but has no ends", f"write {' or '.join(f'{end}: [...]' for end in _ENDS[kind])}"
    if len(ends) > 1:
        return "has both links and sites", 'remove "links" or "sites"', "sites"
    if fixed := next((key for key in ("at", "xyz", "rpy") if key in entry and ends == ["sites"]), ""):
        return f'connects sites, so "{fixed}" has no effect', f'remove "{fixed}"', fixed
    if kind == "connect" and ends == ["links"] and "at" not in entry:
        return 'connects two links, but lacks the point "at"', 'write "at: [X, Y, Z]" in the frame of the first link'
    held = entry[ends[0]]
    if isinstance(held, list) and len(held) == 2 and held[0] == held[1]:
        return f'constrains "{held[0]}" to itself', f"name two different {ends[0]}", ends[0]
    return None


SECTIONS: tuple[Section[Any], ...] = (
    Section("mjcf", lower=lambda tree, _: tuple(tree["mjcf"]), checks=(f"{__name__}.element_rules",)),
    Section("actuators", Actuator, lower=_actuators, checks=(__name__,)),
    Section("constraints", lower=_constraints),
)
