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

from . import convert
from .reading import SLIDE, Reading

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


def drives_of(reading: Reading) -> dict[int, Drive]:
    """Return what drives each hinge and slide, by the joint's index; add all other actuators to the tree."""
    nodes, drives = reading.facts["elements"]["actuators"], dict[int, Drive]()
    others, in_joints, kept = Map(reading.markup.root.span), list[int](), list[Element]()
    elements = reading.elements_of("actuator", nodes)
    for number, (fact, node, element) in enumerate(zip(reading.facts["actuators"], nodes, elements, strict=True)):
        attributes = node["attributes"]
        if {"plugin", "instance"} & attributes.keys() or node["inner"]:
            reading.keep_in_section("actuator", node, f"actuator <{element.tag}>", element.span)
            kept.append(element)
            continue
        if len(kept) > 0 and kept[0] not in reading.reported:
            reading.reported.add(kept[0])
            what = f"the actuator <{kept[0].tag}> is behind those that the language has words for"
            reading.change(f"{what}: its control is not where it was", kept[0].span)
        index = fact["trnid"][0] if "joint" in attributes and fact["trnid"][0] in reading.joint_of else None
        before = drives.get(index) if index is not None else None
        entry = Map(element.span)
        is_in_joint = index is not None and (before is None or before.entry is None)
        if index is not None and is_in_joint:
            joint = reading.joint_of[index]
            name = reading.name("actuator", fact["name"], joint)
            _fill(reading, entry, "actuator", fact, attributes, element, index)
            if name != joint:
                convert.put(entry, "name", name)
            in_joints.append(index)
        else:
            targets = {word: attributes[word] for word in _TARGETS if word in attributes}
            made_up = f"{next(iter(targets.values()), 'robot')}_{element.tag}"
            name = reading.name("actuator", fact["name"], made_up)
            targets = {word: reading.name_of(_KINDS.get(word, "site"), text) for word, text in targets.items()}
            convert.put_words(entry, targets, "other_actuator", element, _WORDS)
            _fill(reading, entry, "other_actuator", fact, attributes, element, index)
            others.put(name, entry, element.span, element.span)
        reading.actuator_of[number] = name
        if index is None:
            continue
        if entry.get("type") is None:
            reading.servos[number] = index
        arrays = (fact["gear"][:1], fact["forcerange"], fact["ctrlrange"])
        gear, force, control = (float(max(map(abs, values))) for values in arrays)
        effort = gear * force if fact["forcelimited"] else None
        is_plain = (fact["gaintype"], fact["biastype"]) == (_FIXED_GAIN, _NO_BIAS)
        if effort is None and is_plain and fact["ctrllimited"]:
            effort = gear * abs(float(fact["gainprm"][0])) * control
        total = before.effort if before else 0.0
        total = None if total is None or effort is None else total + effort
        if is_in_joint:
            drives[index] = Drive(total, entry, _speed(fact, entry))
        elif before is not None:
            drives[index] = before._replace(effort=total)
    if others:
        convert.put(reading.tree, "actuators", others)
    names = list(reading.actuator_of.values())
    reading.in_order = in_joints == sorted(in_joints) and names == [
        *(name for name in names if name not in others),
        *others,
    ]
    return drives


def _fill(
    reading: Reading,
    entry: Map,
    form: str,
    fact: Mapping[str, Any],
    attributes: Mapping[str, str],
    element: Element,
    index: int | None,
) -> None:
    kind, gains, more = _kind(attributes)
    if kind != "position":
        convert.put(entry, "type", kind)
    for word, value in gains.items():
        convert.put_number(entry, word, convert.tidy(value), element, word)
    rest = {key: text for key, text in more.items() if key not in _READ}
    joint = reading.facts["joints"][index] if index is not None else None
    inherits = float(attributes.get("inheritrange", 0)) and kind in ("position", "general")
    is_position = kind == "position"
    if not inherits and (fact["ctrllimited"] or "ctrlrange" in attributes):
        # The range of its joint is the usual one of a position servo.
        ends = [fact["gear"][0] * end for end in joint["range"]] if joint is not None and joint["limited"] else None
        if not is_position or not fact["ctrllimited"] or ends != fact["ctrlrange"]:
            slides = not is_position or joint is None or joint["type"] == SLIDE
            values = [convert.tidy_position(value, slides) for value in fact["ctrlrange"]]
            convert.put(entry, "range", convert.numbers(values, element, "ctrlrange"))
        rest |= {} if fact["ctrllimited"] else {"ctrllimited": "false"}
    elif not inherits and is_position and joint is not None and joint["limited"]:
        convert.put(entry, "unlimited", True)
    if fact["forcelimited"] or "forcerange" in attributes:
        convert.put(entry, "force", convert.listing([convert.tidy(value) for value in fact["forcerange"]], element))
        rest |= {} if fact["forcelimited"] else {"forcelimited": "false"}
    reading.put_words(entry, rest, form, element, f"the actuator <{element.tag}>", _WORDS)


def _kind(attributes: Mapping[str, str]) -> tuple[str, Mapping[str, float], Mapping[str, str]]:
    """Return the type of an actuator by its numbers, its gains, and the other attributes."""
    gain, bias = convert.floats(attributes, "gainprm", [1, 0, 0]), convert.floats(attributes, "biasprm", [0, 0, 0])
    gains, dynamics = attributes.get("gaintype", "fixed"), attributes.get("dyntype", "none")
    attributes = {key: text for key, text in attributes.items() if key != "inheritrange" or float(text)}  # 0 is none
    plain = {key: text for key, text in attributes.items() if key not in _OF_KIND}
    no_servo = {key: text for key, text in plain.items() if key != "inheritrange"}
    if gains == "fixed" and dynamics in ("none", "filterexact") and not any(gain[1:]) and not any(bias[3:]):
        bias_type, kp = attributes.get("biastype", "none"), gain[0]
        filtered = {"timeconst": attributes.get("dynprm", "1").split()[0]} if dynamics == "filterexact" else {}
        if bias_type == "affine" and kp > 0 and bias[:2] == [0, -kp]:
            word = "kv" if bias[2] <= 0 else "damping_ratio"
            return "position", {"kp": kp} | ({word: abs(bias[2])} if bias[2] else {}), plain | filtered
        if bias_type == "affine" and kp > 0 and bias[:3] == [0, 0, -kp] and not filtered:
            return "velocity", {"kv": kp}, no_servo
        if bias_type == "none" and "body" in attributes and not filtered:
            return "adhesion", {}, no_servo | ({"gain": repr(kp)} if kp != 1 else {})
        if bias_type == "none" and kp == 1 and not filtered:
            return "motor", {}, no_servo
    return "general", {}, attributes


def _speed(fact: Mapping[str, Any], entry: Map) -> float | None:
    """Return the speed that a velocity servo can be commanded both ways, which limits the joint in place of a range."""
    (low, high), gear = fact["ctrlrange"], float(fact["gear"][0])
    speed = convert.tidy(high / gear) if gear > 0 else 0.0
    if entry.get("type") != "velocity" or not fact["ctrllimited"] or low != -high or speed <= 0 or gear * speed != high:
        return None
    entry.pop("range", None)
    return speed
