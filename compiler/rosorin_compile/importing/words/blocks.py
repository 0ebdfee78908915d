"""Convert a ``<ros2_control>`` element to an entry of ``control``.

The syntax of both distributions is read; which of them an output uses is decided by the proof. Anything that the
language cannot express raises ``Unsayable``, and the element is kept as it is.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.numbers import exact

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.model import Joint, Robot

_NAME = re.compile(r"[^\s<>&\"']+( +[^\s<>&\"']+)*")
_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_INTERFACE_NUMBERS = {"min": "min", "max": "max", "initial_value": "initial"}
_END_NUMBERS = {"mechanical_reduction": "reduction", "offset": "offset"}


class Unsayable(Exception):
    """Something that the language cannot express; the message names it."""


def block(element: Element, robot: Robot, humble: bool) -> dict[str, Any]:
    """Return the entry of a hardware block, as one distribution reads it. Raises Unsayable."""
    attributes = _attributes(element, "name", "type", "rw_rate", "is_async", "thread_priority")
    _check_children(element, "hardware", "joint", "sensor", "gpio", "transmission")
    kind = attributes.get("type", "")
    if kind not in ("system", "actuator", "sensor"):
        raise Unsayable(f'its type is "{kind}"')
    hardware = _single(element, "hardware")
    _check_children(hardware, "plugin", "param", "group")
    groups = [_text(child) for child in hardware if child.tag == "group"]
    entry: dict[str, Any] = {
        "type": kind if kind != "system" else None,
        "plugin": _text(_single(hardware, "plugin")),
        "group": groups[-1] if groups else None,
        "params": _params(hardware),
    }
    for key, name in (("rw_rate", "rate"), ("thread_priority", "thread_priority")):
        if key in attributes:
            if not re.fullmatch(r"\s*[0-9]+\s*", attributes[key]):
                raise Unsayable(f'{key} is "{attributes[key]}"')
            entry[name] = int(attributes[key])
    if "is_async" in attributes:
        entry["async"] = _flag(attributes["is_async"], "is_async")
    entry["joints"] = _by_name(element, "joint", lambda joint: _joint(joint, robot, humble))
    entry["sensors"] = _by_name(element, "sensor", _sensor)
    entry["gpio"] = _by_name(element, "gpio", lambda gpio: _component(gpio) or None)
    entry["transmissions"] = _by_name(element, "transmission", _transmission)
    return _without_empty(entry)


def _without_empty(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if value or value is False or (value == 0 and value is not None)}


def _joint(element: Element, robot: Robot, humble: bool) -> dict[str, Any] | None:
    name = element.get("name", "")
    joint = robot.joint.get(name)
    entry = _component(element, ("mimic",), ("limits",))
    limits = [child for child in element if child.tag == "limits"]
    if limits:
        if len(limits) > 1 or limits[0].attrib != {"enable": "false"} or len(limits[0]):
            raise Unsayable(f'<limits> of its joint "{name}"')
        entry["limits"] = False
    elif joint is not None and _omits_limits(entry.get("command"), joint):
        entry["limits"] = "urdf"
    if not humble:
        if "mimic" in element.attrib:
            mimics = _flag(element.attrib["mimic"], "mimic")
            if not (joint and joint.mimic and mimics):
                entry["mimic"] = mimics
    elif joint is not None and joint.mimic is not None:
        # Parameters repeat the leader of a joint; without them the hardware moves it.
        params = entry.get("params", {})
        leader, factor = params.pop("mimic", None), params.pop("multiplier", None)
        if leader is None:
            entry["mimic"] = False
        elif str(leader) != joint.mimic.joint or factor is None:
            raise Unsayable(f'its joint "{joint.name}" follows otherwise than in the URDF')
    return _without_empty(entry) or None


def _omits_limits(command: Any, joint: Joint) -> bool:
    """Return True if a command has no limit where its joint has one, which would be written."""
    commands = (
        command
        if isinstance(command, dict)
        else dict.fromkeys([command] if isinstance(command, str) else command or ())
    )
    limits = ((joint.limits_of(interface), entry or {}) for interface, entry in commands.items())
    return any(
        (low is not None and "min" not in entry) or (high is not None and "max" not in entry)
        for (low, high), entry in limits
    )


def _sensor(element: Element) -> dict[str, Any] | None:
    entry = _component(element)
    if "command" in entry:
        raise Unsayable(f'its sensor "{element.get("name", "")}" has commands')
    return entry or None


def _component(element: Element, attributes: tuple[str, ...] = (), tags: tuple[str, ...] = ()) -> dict[str, Any]:
    _attributes(element, "name", *attributes)
    _check_children(element, "command_interface", "state_interface", "param", *tags)
    entry: dict[str, Any] = {}
    for key in ("command", "state"):
        interfaces = _by_name(element, f"{key}_interface", _interface)
        names = list(interfaces)
        entry[key] = interfaces if any(interfaces.values()) else names[0] if len(names) == 1 else names
    return _without_empty({**entry, "params": _params(element)})


def _interface(element: Element) -> dict[str, Any] | None:
    attributes = _attributes(element, "name", "data_type", "size")
    _check_children(element, "param")
    params = _params(element)
    entry: dict[str, Any] = {}
    for name, key in _INTERFACE_NUMBERS.items():
        value = params.get(name)
        number = value if isinstance(value, float) else _number(value) if isinstance(value, str) else None
        if number is not None:
            entry[key] = number
            del params[name]
    if "data_type" in attributes:
        entry["data_type"] = attributes["data_type"]
    if "size" in attributes:
        if not re.fullmatch(r"\s*[0-9]+\s*", attributes["size"]):
            raise Unsayable(f'size is "{attributes["size"]}"')
        entry["size"] = int(attributes["size"])
    return {**entry, **({"params": params} if params else {})} or None


def _transmission(element: Element) -> dict[str, Any]:
    _attributes(element, "name")
    _check_children(element, "plugin", "joint", "actuator")
    ends = {f"{tag}s": _by_name(element, tag, _transmission_end) for tag in ("joint", "actuator")}
    if not all(ends.values()):
        raise Unsayable("a transmission without a joint or an actuator")
    return {"plugin": _text(_single(element, "plugin")), **ends}


def _transmission_end(element: Element) -> dict[str, Any] | None:
    attributes = _attributes(element, "name", "role")
    entry: dict[str, Any] = {"role": attributes["role"]} if "role" in attributes else {}
    for child in element:
        key, number = _END_NUMBERS.get(child.tag), _number(_text(child))
        if key is None or number is None:
            raise Unsayable(f"<{child.tag}> of <{element.tag}> in <transmission>")
        entry[key] = number
    return entry or None


def _by_name(element: Element, tag: str, read: Callable[[Element], Any]) -> dict[str, Any]:
    """Return the entries of all children with a tag, by name."""
    entries: dict[str, Any] = {}
    for child in (child for child in element if child.tag == tag):
        name = child.get("name", "")
        if not _NAME.fullmatch(name):
            raise Unsayable(f'a <{tag}> is called "{name}"')
        if name in entries:
            raise Unsayable(f'two <{tag}> are called "{name}"')
        entries[name] = read(child)
    return entries


def _params(element: Element) -> dict[str, Any]:
    params: dict[str, Any] = {}
    for child in (child for child in element if child.tag == "param"):
        name, text = child.get("name", ""), (child.text or "").strip()
        if set(child.attrib) != {"name"} or not _NAME.fullmatch(name) or name in params or len(child):
            raise Unsayable(f'<param name="{name}"> is more than a name and a text, or is repeated')
        if not text:
            raise Unsayable(f'<param name="{name}"> is empty')
        params[name] = plain(text)
    return params


def plain(text: str) -> Any:
    """Return the value that is written as this very text: a number, true or false, else the text."""
    if text in ("true", "false"):
        return text == "true"
    number = _number(text)
    return number if number is not None and exact(number) == text else text


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if "_" not in text and number - number == 0 else None


def _flag(text: str, name: str) -> bool:
    if text.strip() not in _FLAGS:
        raise Unsayable(f'{name} is "{text}"')
    return _FLAGS[text.strip()]


def _attributes(element: Element, *known: str) -> Mapping[str, str]:
    unknown = next((name for name in element.attrib if name not in known), None)
    if unknown is not None:
        raise Unsayable(f'the attribute "{unknown}" of <{element.tag}>')
    return element.attrib


def _check_children(element: Element, *known: str) -> None:
    unknown = next((child.tag for child in element if child.tag not in known), None)
    if unknown is not None:
        raise Unsayable(f"<{unknown}> in <{element.tag}>")


def _single(element: Element, tag: str) -> Element:
    found = [child for child in element if child.tag == tag]
    if len(found) != 1:
        raise Unsayable(f"{len(found) or 'no'} <{tag}> in <{element.tag}>")
    return found[0]


def _text(element: Element) -> str:
    if element.attrib or len(element):
        raise Unsayable(f"<{element.tag}> is more than a text")
    return (element.text or "").strip()
