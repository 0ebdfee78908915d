"""Blocks: a ``<ros2_control>`` as an entry of ``control``.

The words of both distributions are read; which of them an output asks for is decided by the proof. What has no word is
``Unsayable``, and the block stays as it is.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.numbers import exact

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Robot

_TYPES = ("system", "actuator", "sensor")
_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")
_WHOLE = re.compile(r"[0-9]+")
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_OF_INTERFACE = {"min": "min", "max": "max", "initial_value": "initial"}
_ENDS = {"joint": "joints", "actuator": "actuators"}


class Unsayable(Exception):
    """Something that the language has no word for, in words."""


def block(element: Element, robot: Robot, humble: bool) -> dict[str, Any]:
    """Return the entry of a hardware block, as one distribution reads it. Raises Unsayable."""
    made: dict[str, Any] = {}
    kind = _attributes(element, "name", "type", "rw_rate", "is_async", "thread_priority").get("type", "")
    if kind not in _TYPES:
        raise Unsayable(f'its type is "{kind}"')
    if kind != "system":
        made["type"] = kind
    hardware = _single(element, "hardware")
    made["plugin"] = _text(_single(hardware, "plugin"))
    for child in hardware:
        if child.tag == "group":
            made["group"] = _text(child)
        elif child.tag not in ("plugin", "param"):
            raise Unsayable(f"<{child.tag}> in its <hardware>")
    _put(made, "params", _params(hardware))
    for key, name in (("rw_rate", "rate"), ("thread_priority", "thread_priority")):
        if key in element.attrib:
            made[name] = _whole(element.attrib[key], key)
    if "is_async" in element.attrib:
        made["async"] = _flag(element.attrib["is_async"], "is_async")
    _put(made, "joints", _each(element, "joint", lambda one: _joint(one, robot, humble)))
    _put(made, "sensors", _each(element, "sensor", _sensor))
    _put(made, "gpio", _each(element, "gpio", lambda one: _component(one)))
    _put(made, "transmissions", _each(element, "transmission", _transmission))
    known = ("hardware", "joint", "sensor", "gpio", "transmission")
    for child in element:
        if child.tag not in known:
            raise Unsayable(f"<{child.tag}>")
    return made


def _joint(element: Element, robot: Robot, humble: bool) -> dict[str, Any] | None:
    name, joint = element.get("name", ""), robot.joint.get(element.get("name", ""))
    made: dict[str, Any] = _component(element, ("mimic",), ("limits",)) or {}
    limits = [child for child in element if child.tag == "limits"]
    if limits:
        if len(limits) > 1 or limits[0].attrib != {"enable": "false"} or len(limits[0]):
            raise Unsayable(f'<limits> of its joint "{name}"')
        made["limits"] = False
    elif made.get("command") and _leaves_limits(made, joint):
        made["limits"] = "urdf"
    if humble:
        _humble_mimic(made, joint)
    elif "mimic" in element.attrib and not (joint and joint.mimic and _flag(element.attrib["mimic"], "mimic")):
        made["mimic"] = _flag(element.attrib["mimic"], "mimic")
    return made or None


def _leaves_limits(made: Mapping[str, Any], joint: Any) -> bool:
    """Say whether a command lacks a limit that its joint has, so that it would be written."""
    if joint is None:
        return False
    said = made["command"] if isinstance(made["command"], dict) else dict.fromkeys(_listed(made["command"]))
    for interface, entry in said.items():
        low, high = joint.limits_of(interface)
        if (low is not None and "min" not in (entry or {})) or (high is not None and "max" not in (entry or {})):
            return True
    return False


def _humble_mimic(made: dict[str, Any], joint: Any) -> None:
    """Take the parameters that say again whom a joint follows; where they are not there, the hardware moves it."""
    if joint is None or joint.mimic is None:
        return
    params = dict(made.get("params") or {})
    leader, factor = params.pop("mimic", None), params.pop("multiplier", None)
    if leader is None:
        made["mimic"] = False
        return
    if str(leader) != joint.mimic.joint or factor is None:
        raise Unsayable(f'its joint "{joint.name}" follows otherwise than in the URDF')
    made.pop("params", None)
    _put(made, "params", params)


def _sensor(element: Element) -> dict[str, Any] | None:
    made = _component(element) or {}
    if "command" in made:
        raise Unsayable(f'its sensor "{element.get("name", "")}" has commands')
    return made or None


def _component(element: Element, attributes: tuple[str, ...] = (), tags: tuple[str, ...] = ()) -> dict[str, Any] | None:
    _attributes(element, "name", *attributes)
    made: dict[str, Any] = {}
    for tag, key in (("command_interface", "command"), ("state_interface", "state")):
        found = _each(element, tag, _interface)
        if found:
            made[key] = found if any(found.values()) else _shortest(list(found))
    _put(made, "params", _params(element))
    for child in element:
        if child.tag not in ("command_interface", "state_interface", "param", *tags):
            raise Unsayable(f"<{child.tag}> in <{element.tag}>")
    return made or None


def _interface(element: Element) -> dict[str, Any] | None:
    attributes = _attributes(element, "name", "data_type", "size")
    made: dict[str, Any] = {}
    params = _params(element)
    for name, key in _OF_INTERFACE.items():
        if isinstance(params.get(name), (int, float)) and not isinstance(params[name], bool):
            made[key] = params.pop(name)
        elif isinstance(params.get(name), str):
            number = _float(params[name])
            if number is not None:
                made[key] = number
                del params[name]
    if "data_type" in attributes:
        made["data_type"] = attributes["data_type"]
    if "size" in attributes:
        made["size"] = _whole(attributes["size"], "size")
    if any(child.tag != "param" for child in element):
        raise Unsayable(f"more than parameters in <{element.tag}>")
    _put(made, "params", params)
    return made or None


def _transmission(element: Element) -> dict[str, Any]:
    _attributes(element, "name")
    made: dict[str, Any] = {"plugin": _text(_single(element, "plugin"))}
    for tag, key in _ENDS.items():
        _put(made, key, _each(element, tag, _end))
    if {"joints", "actuators"} - made.keys():
        raise Unsayable("a transmission without a joint or an actuator")
    for child in element:
        if child.tag not in ("plugin", *_ENDS):
            raise Unsayable(f"<{child.tag}> in <transmission>")
    return made


def _end(element: Element) -> dict[str, Any] | None:
    made: dict[str, Any] = {}
    if "role" in _attributes(element, "name", "role"):
        made["role"] = element.attrib["role"]
    for child in element:
        key = {"mechanical_reduction": "reduction", "offset": "offset"}.get(child.tag)
        number = _float(_text(child))
        if key is None or number is None:
            raise Unsayable(f"<{child.tag}> of <{element.tag}> in <transmission>")
        made[key] = number
    return made or None


def _each(element: Element, tag: str, read: Any) -> dict[str, Any]:
    """Return the entries of all children of a tag, by name."""
    made: dict[str, Any] = {}
    for child in element:
        if child.tag != tag:
            continue
        name = child.get("name", "")
        if not _NAME.fullmatch(name):
            raise Unsayable(f'a <{tag}> is called "{name}"')
        if name in made:
            raise Unsayable(f'two <{tag}> are called "{name}"')
        made[name] = read(child)
    return made


def _params(element: Element) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for child in element:
        if child.tag != "param":
            continue
        name = child.get("name", "")
        if set(child.attrib) != {"name"} or not _NAME.fullmatch(name) or name in made or len(child):
            raise Unsayable(f'<param name="{name}"> is more than a name and a text, or stands twice')
        text = (child.text or "").strip()
        if not text:
            raise Unsayable(f'<param name="{name}"> is empty')
        made[name] = plain(text)
    return made


def plain(text: str) -> Any:
    """Return a text as the value that is written as this very text: a number, true or false, else the text."""
    if text in ("true", "false"):
        return text == "true"
    number = _float(text)
    return number if number is not None and exact(number) == text else text


def _float(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if "_" not in text and number - number == 0 else None


def _attributes(element: Element, *known: str) -> Mapping[str, str]:
    for name in element.attrib:
        if name not in known:
            raise Unsayable(f'the attribute "{name}" of <{element.tag}>')
    return element.attrib


def _single(element: Element, tag: str) -> Element:
    found = [child for child in element if child.tag == tag]
    if len(found) != 1:
        raise Unsayable(f"{len(found) or 'no'} <{tag}> in <{element.tag}>")
    return found[0]


def _text(element: Element) -> str:
    if element.attrib or len(element):
        raise Unsayable(f"<{element.tag}> is more than a text")
    return (element.text or "").strip()


def _whole(text: str, what: str) -> int:
    if not _WHOLE.fullmatch(text.strip()):
        raise Unsayable(f'{what} is "{text}"')
    return int(text)


def _flag(text: str, what: str) -> bool:
    if text.strip() not in _FLAGS:
        raise Unsayable(f'{what} is "{text}"')
    return _FLAGS[text.strip()]


def _listed(value: Any) -> list[str]:
    return [value] if isinstance(value, str) else list(value)


def _shortest(names: list[str]) -> str | list[str]:
    return names[0] if len(names) == 1 else names


def _put(made: dict[str, Any], key: str, value: Any) -> None:
    if value:
        made[key] = value
