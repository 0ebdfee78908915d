"""Actuators: the first one of a joint stands beside it, all others have entries of their own.

MuJoCo takes ``<position>``, ``<velocity>`` and ``<motor>`` for short forms of ``<general>`` with certain numbers, and
compiles all to those numbers; so what has these numbers is called by the short form here. The strength of a joint, for
readers of URDF, is what its actuators can bring.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .reading import SLIDE, Reading, numbers, put, put_number, tidy, tidy_position
from .worded import Node, floats, listing, put_words

_FIXED_GAIN, _NO_BIAS = 0, 0  # mjtGain, mjtBias

_TARGETS = ("joint", "jointinparent", "tendon", "site", "refsite", "slidersite", "cranksite", "body")
_KINDS = {"joint": "joint", "jointinparent": "joint", "tendon": "tendon", "body": "body"}
_WORDS = {
    "jointinparent": "joint_in_parent",
    "refsite": "reference_site",
    "slidersite": "slider_site",
    "cranksite": "crank_site",
    "forcerange": "force",
}
# What says of which kind an actuator is, and what is read of the compiled model.
_OF_KIND = ("gaintype", "gainprm", "biastype", "biasprm", "dyntype", "dynprm", "input")
_READ = ("name", "ctrlrange", "ctrllimited", "forcerange", "forcelimited", *_TARGETS)


class Drive(NamedTuple):
    """What drives a joint: the largest torque (N*m) or force (N), if known, and the entry beside it, if there is one.

    ``speed`` is the largest speed (rad/s or m/s) that the servo beside it can be asked for, if it is one of speed.
    """

    effort: float | None = None
    entry: Map | None = None
    speed: float | None = None


class _Kind(NamedTuple):
    """What kind of actuator it is: its type, its gains, and the attributes that remain to be said."""

    type: str
    gains: Mapping[str, float]
    rest: Mapping[str, str]


def drives_of(reading: Reading) -> dict[int, Drive]:
    """Return what drives each hinge and slide, by the joint's index; add all other actuators to the tree."""
    nodes = reading.facts["elements"]["actuators"]
    elements = reading.markup.listed("actuator")
    facts: Sequence[Mapping[str, Any]] = reading.facts["actuators"]
    if len(elements) != len(facts):  # attached from another file
        elements = [reading.markup.named("actuator", fact["name"]) or reading.markup.root for fact in facts]
    drives: dict[int, Drive] = {}
    others, beside = Map(reading.markup.root.span), []
    kept: Element | None = None
    for number, (fact, node, element) in enumerate(zip(facts, nodes, elements, strict=True)):
        index = _joint(reading, fact, node)
        before = drives.get(index) if index is not None else None
        if {"plugin", "instance"} & node["attributes"].keys() or node["inner"]:
            _keep(reading, node, element)
            kept = kept or element
            continue
        if kept is not None and kept not in reading.told:
            reading.told.add(kept)
            what = f"the actuator <{kept.tag}> stands behind those that the language has words for"
            reading.changed(f"{what}: its control is not where it was", kept.span)
        entry = None
        if index is not None and (before is None or before.entry is None):
            entry = _beside(reading, index, fact, node, element)
            beside.append(index)
            name = entry.get("name") or reading.joint_of[index]
        else:
            name = _add(reading, others, fact, node, element)
        if name:
            reading.actuators.append(name)
            reading.actuator_of[number] = name
        if index is not None:
            if (entry or others[name]).get("type") is None:
                reading.servos[number] = index
            known, effort = (before.effort if before else 0.0), _effort(fact)
            total = None if known is None or effort is None else known + effort
            speed = _speed(fact, entry) if entry else before.speed if before else None
            drives[index] = Drive(total, entry or (before.entry if before else None), speed)
    if others:
        put(reading.tree, "actuators", others)
    reading.in_order = beside == sorted(beside) and reading.actuators == _usual_order(reading, others)
    return drives


def _usual_order(reading: Reading, others: Map) -> list[str]:
    """Return the names of the actuators in the order in which an MJCF of ours has them by itself."""
    return [*(name for name in reading.actuators if name not in others), *others]


def _joint(reading: Reading, fact: Mapping[str, Any], node: Node) -> int | None:
    """Return the hinge or slide that an actuator acts on, None if it acts on anything else."""
    if "joint" not in node["attributes"]:
        return None
    index: int = fact["target"][0]
    return index if index in reading.joint_of else None


def _beside(reading: Reading, index: int, fact: Mapping[str, Any], node: Node, element: Element) -> Map:
    """Return the entry of an actuator that stands beside its joint."""
    joint = reading.joint_of[index]
    name = reading.name("actuator", fact["name"], joint)
    entry = Map(element.span)
    _fill(reading, entry, "actuator", (fact, node, element), index)
    if name != joint:
        put(entry, "name", name)
    return entry


def _add(reading: Reading, others: Map, fact: Mapping[str, Any], node: Node, element: Element) -> str:
    """Add the entry of an actuator that stands by itself, and return its name; empty for one that cannot be."""
    said = node["attributes"]
    target = next((said[word] for word in _TARGETS if word in said), "robot")
    name = reading.name("actuator", fact["name"], f"{target}_{element.tag}")
    entry = Map(element.span)
    targets = {word: said[word] for word in _TARGETS if word in said}
    put_words(entry, targets, "other_actuator", element, _WORDS, lambda word, text: _called(reading, word, text))
    index = _joint(reading, fact, node)
    _fill(reading, entry, "other_actuator", (fact, node, element), index)
    others.put(name, entry, element.span, element.span)
    return name


def _called(reading: Reading, word: str, name: str) -> str:
    return reading.called(_KINDS.get(word, "site"), name)


def _keep(reading: Reading, node: Node, element: Element) -> None:
    """Keep an actuator as it is, behind all others."""
    whole = {"tag": "actuator", "attributes": {}, "inner": [node]}
    reading.kept(whole, f"actuator <{element.tag}>", element.span)


def _fill(
    reading: Reading,
    entry: Map,
    form: str,
    actuator: tuple[Mapping[str, Any], Mapping[str, Any], Element],
    index: int | None,
) -> None:
    """Set what an actuator is and can be asked for."""
    fact, node, element = actuator
    kind = _kind(node["attributes"])
    if kind.type != "position":
        put(entry, "type", kind.type)
    for word, value in kind.gains.items():
        put_number(entry, word, tidy(value), element, word)
    rest = {key: text for key, text in kind.rest.items() if key not in _READ}
    rest |= _limits(reading, entry, kind.type, (fact, node["attributes"], element), index)
    for name in put_words(entry, rest, form, element, _WORDS):
        reading.lost(f'"{name}" of the actuator <{element.tag}>', element.span)


def _kind(said: Mapping[str, str]) -> _Kind:
    """Return the kind of an actuator by its numbers."""
    gain, bias = floats(said, "gainprm", [1, 0, 0]), floats(said, "biasprm", [0, 0, 0])
    gains, dynamics = said.get("gaintype", "fixed"), said.get("dyntype", "none")
    said = {key: text for key, text in said.items() if key != "inheritrange" or float(text)}  # 0 is none
    plain = {key: text for key, text in said.items() if key not in _OF_KIND}
    asked = {key: text for key, text in plain.items() if key != "inheritrange"}  # what holds no position has a range
    if gains == "fixed" and dynamics in ("none", "filterexact") and not any(gain[1:]) and not any(bias[3:]):
        affine, kp = said.get("biastype", "none") == "affine", gain[0]
        filtered = {"timeconst": said.get("dynprm", "1").split()[0]} if dynamics == "filterexact" else {}
        if affine and kp > 0 and bias[:2] == [0, -kp]:
            word = "kv" if bias[2] <= 0 else "damping_ratio"
            return _Kind("position", {"kp": kp} | ({word: abs(bias[2])} if bias[2] else {}), plain | filtered)
        if affine and kp > 0 and bias[:3] == [0, 0, -kp] and not filtered:
            return _Kind("velocity", {"kv": kp}, asked)
        if said.get("biastype", "none") == "none" and "body" in said and not filtered:
            return _Kind("adhesion", {}, asked | ({"gain": repr(kp)} if kp != 1 else {}))
        if said.get("biastype", "none") == "none" and kp == 1 and not filtered:
            return _Kind("motor", {}, asked)
    return _Kind("general", {}, said)


def _limits(
    reading: Reading,
    entry: Map,
    kind: str,
    actuator: tuple[Mapping[str, Any], Mapping[str, str], Element],
    index: int | None,
) -> dict[str, str]:
    """Set what an actuator can be asked for and what it can bring; return what is to be said in MuJoCo's words."""
    fact, said, element = actuator
    rest = {}
    joint = reading.facts["joints"][index] if index is not None else None
    cut = tidy if joint is None or joint["type"] == SLIDE or kind != "position" else tidy_position
    asked = [cut(value) for value in fact["control"]]
    if float(said.get("inheritrange", 0)) and kind in ("position", "general"):
        pass
    elif fact["controlled"] or "ctrlrange" in said:
        if kind != "position" or not fact["controlled"] or not _has_range_of(joint, fact):
            put(entry, "range", numbers(asked, element, "ctrlrange"))
        if not fact["controlled"]:
            rest["ctrllimited"] = "false"
    elif kind == "position" and joint is not None and joint["limited"]:
        put(entry, "unlimited", True)
    if fact["forced"] or "forcerange" in said:
        put(entry, "force", listing([tidy(value) for value in fact["force"]], element))
        if not fact["forced"]:
            rest["forcelimited"] = "false"
    return rest


def _speed(fact: Mapping[str, Any], entry: Map) -> float | None:
    """Return the speed that a servo of speed can be asked for both ways: it limits the joint, and needs no range.

    None if it is another servo, or has another range.
    """
    (low, high), gear = fact["control"], float(fact["gear"][0])
    speed = tidy(high / gear) if gear > 0 else 0.0
    if entry.get("type") != "velocity" or not fact["controlled"] or low != -high or speed <= 0 or gear * speed != high:
        return None
    entry.pop("range", None)
    return speed


def _has_range_of(joint: Mapping[str, Any] | None, fact: Mapping[str, Any]) -> bool:
    """Say whether an actuator can be asked for the range of its joint, which goes without saying."""
    gear = fact["gear"][0]
    return joint is not None and joint["limited"] and [gear * end for end in joint["range"]] == fact["control"]


def _effort(fact: Mapping[str, Any]) -> float | None:
    """Return the largest torque or force that an actuator brings to its joint, None if that is not said."""
    gear, force, control = (
        float(max(map(abs, values))) for values in (fact["gear"][:1], fact["force"], fact["control"])
    )
    if fact["forced"]:
        return gear * force
    if (fact["gain"], fact["bias"]) == (_FIXED_GAIN, _NO_BIAS) and fact["controlled"]:
        return gear * abs(float(fact["gainprm"][0])) * control
    return None
