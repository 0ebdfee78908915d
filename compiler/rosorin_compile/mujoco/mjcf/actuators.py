"""Actuators: the first one of a joint is part of its entry, all others have entries of their own.

MuJoCo takes ``<position>``, ``<velocity>`` and ``<motor>`` for short forms of ``<general>`` with certain numbers, and
compiles all to those numbers; so an actuator with these numbers becomes the short form here. The effort of a joint, for
readers of URDF, is what its actuators can bring.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import Element

from .reading import SLIDE, Reading
from .values import Node, floats, listing, numbers, put, put_number, put_words, tidy, tidy_position

_FIXED_GAIN, _NO_BIAS = 0, 0  # mjtGain, mjtBias

_TARGETS = ("joint", "jointinparent", "tendon", "site", "refsite", "slidersite", "cranksite", "body")
_KINDS = {"joint": "joint", "jointinparent": "joint", "tendon": "tendon", "body": "body"}  # the others name sites
_WORDS = {
    "jointinparent": "joint_in_parent",
    "refsite": "reference_site",
    "slidersite": "slider_site",
    "cranksite": "crank_site",
    "forcerange": "force",
}
# What decides the kind of an actuator, and what is read of the compiled model.
_OF_KIND = ("gaintype", "gainprm", "biastype", "biasprm", "dyntype", "dynprm", "input")
_READ = ("name", "ctrlrange", "ctrllimited", "forcerange", "forcelimited", *_TARGETS)


class Drive(NamedTuple):
    """What drives a joint: the largest torque (N*m) or force (N), if known, and the entry in the joint, if it has one.

    ``speed`` is the largest speed (rad/s or m/s) that a velocity servo there can be commanded.
    """

    effort: float | None = None
    entry: Map | None = None
    speed: float | None = None


class _Actuator(NamedTuple):
    """An actuator: of the compiled model, as an element, in the text, and the hinge or slide that it acts on."""

    fact: Mapping[str, Any]
    node: Node
    element: Element
    joint: int | None

    @property
    def attributes(self) -> Mapping[str, str]:
        attributes: Mapping[str, str] = self.node["attributes"]
        return attributes


class _Kind(NamedTuple):
    """The kind of an actuator: its type, its gains, and the other attributes."""

    type: str
    gains: Mapping[str, float]
    rest: Mapping[str, str]


def drives_of(reading: Reading) -> dict[int, Drive]:
    """Return what drives each hinge and slide, by the joint's index; add all other actuators to the tree."""
    nodes = reading.facts["elements"]["actuators"]
    drives: dict[int, Drive] = {}
    others, in_joints = Map(reading.markup.root.span), []
    kept: Element | None = None
    elements = reading.elements_of("actuator", nodes)
    for number, (fact, node, element) in enumerate(zip(reading.facts["actuators"], nodes, elements, strict=True)):
        if {"plugin", "instance"} & node["attributes"].keys() or node["inner"]:
            reading.keep_in_section("actuator", node, f"actuator <{element.tag}>", element.span)
            kept = kept or element
            continue
        if kept is not None and kept not in reading.reported:
            reading.reported.add(kept)
            what = f"the actuator <{kept.tag}> is behind those that the language has words for"
            reading.changed(f"{what}: its control is not where it was", kept.span)
        target = fact["target"][0] if "joint" in node["attributes"] else None
        index = target if target in reading.joint_of else None
        actuator, before = _Actuator(fact, node, element, index), drives.get(index) if index is not None else None
        entry = None
        if index is not None and (before is None or before.entry is None):
            entry, name = _entry_in_joint(reading, actuator, reading.joint_of[index])
            in_joints.append(index)
        else:
            name = _add(reading, others, actuator)
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
    usual = [*(name for name in reading.actuators if name not in others), *others]
    reading.in_order = in_joints == sorted(in_joints) and reading.actuators == usual
    return drives


def _entry_in_joint(reading: Reading, actuator: _Actuator, joint: str) -> tuple[Map, str]:
    """Return the entry of an actuator in its joint, and its name."""
    name, entry = reading.name("actuator", actuator.fact["name"], joint), Map(actuator.element.span)
    _fill(reading, entry, "actuator", actuator)
    if name != joint:
        put(entry, "name", name)
    return entry, name


def _add(reading: Reading, others: Map, actuator: _Actuator) -> str:
    """Add an entry of its own for an actuator, and return its name."""
    element, targets = (
        actuator.element,
        {word: actuator.attributes[word] for word in _TARGETS if word in actuator.attributes},
    )
    name = reading.name("actuator", actuator.fact["name"], f"{next(iter(targets.values()), 'robot')}_{element.tag}")
    entry = Map(element.span)
    put_words(
        entry,
        targets,
        "other_actuator",
        element,
        _WORDS,
        lambda word, text: reading.called(_KINDS.get(word, "site"), text),
    )
    _fill(reading, entry, "other_actuator", actuator)
    others.put(name, entry, element.span, element.span)
    return name


def _fill(reading: Reading, entry: Map, form: str, actuator: _Actuator) -> None:
    """Set the kind of an actuator, its gains and its limits."""
    kind, element = _kind(actuator.attributes), actuator.element
    if kind.type != "position":
        put(entry, "type", kind.type)
    for word, value in kind.gains.items():
        put_number(entry, word, tidy(value), element, word)
    rest = {key: text for key, text in kind.rest.items() if key not in _READ}
    rest |= _put_limits(reading, entry, kind.type, actuator)
    reading.put_words(entry, rest, form, element, f"the actuator <{element.tag}>", _WORDS)


def _kind(attributes: Mapping[str, str]) -> _Kind:
    """Return the kind of an actuator by its numbers."""
    gain, bias = floats(attributes, "gainprm", [1, 0, 0]), floats(attributes, "biasprm", [0, 0, 0])
    gains, dynamics = attributes.get("gaintype", "fixed"), attributes.get("dyntype", "none")
    attributes = {key: text for key, text in attributes.items() if key != "inheritrange" or float(text)}  # 0 is none
    plain = {key: text for key, text in attributes.items() if key not in _OF_KIND}
    no_servo = {key: text for key, text in plain.items() if key != "inheritrange"}
    if gains == "fixed" and dynamics in ("none", "filterexact") and not any(gain[1:]) and not any(bias[3:]):
        bias_type, kp = attributes.get("biastype", "none"), gain[0]
        filtered = {"timeconst": attributes.get("dynprm", "1").split()[0]} if dynamics == "filterexact" else {}
        if bias_type == "affine" and kp > 0 and bias[:2] == [0, -kp]:
            word = "kv" if bias[2] <= 0 else "damping_ratio"
            return _Kind("position", {"kp": kp} | ({word: abs(bias[2])} if bias[2] else {}), plain | filtered)
        if bias_type == "affine" and kp > 0 and bias[:3] == [0, 0, -kp] and not filtered:
            return _Kind("velocity", {"kv": kp}, no_servo)
        if bias_type == "none" and "body" in attributes and not filtered:
            return _Kind("adhesion", {}, no_servo | ({"gain": repr(kp)} if kp != 1 else {}))
        if bias_type == "none" and kp == 1 and not filtered:
            return _Kind("motor", {}, no_servo)
    return _Kind("general", {}, attributes)


def _put_limits(reading: Reading, entry: Map, kind: str, actuator: _Actuator) -> dict[str, str]:
    """Set the ranges of control and force of an actuator; return what only MuJoCo's words express."""
    fact, attributes, element, rest = actuator.fact, actuator.attributes, actuator.element, dict[str, str]()
    joint = reading.facts["joints"][actuator.joint] if actuator.joint is not None else None
    inherits = float(attributes.get("inheritrange", 0)) and kind in ("position", "general")
    if not inherits and (fact["controlled"] or "ctrlrange" in attributes):
        gear, is_position = fact["gear"][0], kind == "position"
        # The range of its joint is the usual one of a position servo.
        ends = [gear * end for end in joint["range"]] if joint is not None and joint["limited"] else None
        if not is_position or not fact["controlled"] or ends != fact["control"]:
            cut = tidy_position if is_position and joint is not None and joint["type"] != SLIDE else tidy
            put(entry, "range", numbers([cut(value) for value in fact["control"]], element, "ctrlrange"))
        rest |= {} if fact["controlled"] else {"ctrllimited": "false"}
    elif not inherits and kind == "position" and joint is not None and joint["limited"]:
        put(entry, "unlimited", True)
    if fact["forced"] or "forcerange" in attributes:
        put(entry, "force", listing([tidy(value) for value in fact["force"]], element))
        rest |= {} if fact["forced"] else {"forcelimited": "false"}
    return rest


def _speed(fact: Mapping[str, Any], entry: Map) -> float | None:
    """Return the speed that a velocity servo can be commanded both ways: it limits the joint, and needs no range.

    None for another servo or range.
    """
    (low, high), gear = fact["control"], float(fact["gear"][0])
    speed = tidy(high / gear) if gear > 0 else 0.0
    if entry.get("type") != "velocity" or not fact["controlled"] or low != -high or speed <= 0 or gear * speed != high:
        return None
    entry.pop("range", None)
    return speed


def _effort(fact: Mapping[str, Any]) -> float | None:
    """Return the largest torque or force that an actuator brings to its joint, or None if it is not known."""
    gear, force, control = (
        float(max(map(abs, values))) for values in (fact["gear"][:1], fact["force"], fact["control"])
    )
    if fact["forced"]:
        return gear * force
    if (fact["gain"], fact["bias"]) == (_FIXED_GAIN, _NO_BIAS) and fact["controlled"]:
        return gear * abs(float(fact["gainprm"][0])) * control
    return None
