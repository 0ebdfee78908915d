"""Convert a ``<ros2_control>`` element to an entry of ``control``.

The syntax of both distributions is read. Content that an entry cannot represent is detected when the entry is written
back and compared with the element.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element

from rosorin_compile.source.numbers import exact

if TYPE_CHECKING:
    from rosorin_compile.model import Robot

_FLAGS = {"true": True, "True": True, "false": False, "False": False}
_INTERFACE_NUMBERS = {"min": "min", "max": "max", "initial_value": "initial"}


def block(element: Element, robot: Robot, humble: bool) -> dict[str, Any]:
    """Return the entry of a hardware block, as one distribution reads it."""
    hardware = element.find("hardware")
    hardware = Element("hardware") if hardware is None else hardware
    kind = element.get("type", "").strip()
    groups = [_text(child) for child in hardware if child.tag == "group"]
    flag = element.get("is_async", "").strip()
    return _without_empty(
        {
            "type": None if kind == "system" else kind,
            "plugin": _text(hardware.find("plugin")),
            "group": groups[-1] if groups else None,
            "params": _params(hardware),
            "rate": _integer(element.get("rw_rate")),
            "thread_priority": _integer(element.get("thread_priority")),
            "async": _FLAGS.get(flag, flag),
            "joints": _by_name(element, "joint", lambda joint: _joint(joint, robot, humble)),
            "sensors": _by_name(element, "sensor", lambda sensor: _component(sensor) or None),
            "gpio": _by_name(element, "gpio", lambda gpio: _component(gpio) or None),
        }
    )


def _without_empty(entry: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in entry.items() if value or value is False or (value == 0 and value is not None)}


def _joint(element: Element, robot: Robot, humble: bool) -> dict[str, Any] | None:
    joint = robot.joint.get(element.get("name", ""))
    entry = _component(element)
    if element.find("limits") is not None:
        entry["limits"] = False
    elif joint is not None:
        commands = entry.get("command", {})
        if not isinstance(commands, dict):
            commands = dict.fromkeys([commands] if isinstance(commands, str) else commands)
        for interface, numbers in commands.items():  # a command without a limit where its joint has one
            low, high = joint.limits_of(interface)
            ends = {end for end, limit in (("min", low), ("max", high)) if limit is not None}
            if not ends <= (numbers or {}).keys():
                entry["limits"] = "urdf"
    if not humble and "mimic" in element.attrib:
        flag = element.attrib["mimic"].strip()
        if not (joint and joint.mimic and _FLAGS.get(flag) is True):
            entry["mimic"] = _FLAGS.get(flag, flag)
    elif humble and joint is not None and joint.mimic is not None:
        # Parameters repeat the leader of a joint; without them the hardware moves it.
        params = entry.get("params", {})
        if params.pop("mimic", None) is None:
            entry["mimic"] = False
        params.pop("multiplier", None)
    return _without_empty(entry) or None


def _component(element: Element) -> dict[str, Any]:
    entry: dict[str, Any] = {}
    for key in ("command", "state"):
        interfaces = _by_name(element, f"{key}_interface", _interface)
        names = list(interfaces)
        entry[key] = interfaces if any(interfaces.values()) else names[0] if len(names) == 1 else names
    return _without_empty({**entry, "params": _params(element)})


def _interface(element: Element) -> dict[str, Any] | None:
    params = _params(element)
    entry: dict[str, Any] = {}
    for name, key in _INTERFACE_NUMBERS.items():
        number = _number(str(params.get(name, "")))
        if number is not None:
            entry[key] = number
            del params[name]
    entry |= {"data_type": element.get("data_type"), "size": _integer(element.get("size")), "params": params}
    return _without_empty(entry) or None


def _by_name(element: Element, tag: str, read: Callable[[Element], Any]) -> dict[str, Any]:
    """Return the entries of all children with a tag, by name."""
    return {child.get("name", ""): read(child) for child in element if child.tag == tag}


def _params(element: Element) -> dict[str, Any]:
    return {child.get("name", ""): plain(_text(child)) for child in element if child.tag == "param"}


def plain(text: str) -> Any:
    """Return the number or boolean that is written exactly like this text, otherwise the text."""
    if text in ("true", "false"):
        return text == "true"
    number = _number(text)
    return number if number is not None and exact(number) == text else text


def _integer(text: str | None) -> Any:
    return int(text) if text is not None and text.strip().isdecimal() else text


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if "_" not in text and number - number == 0 else None


def _text(element: Element | None) -> str:
    return "" if element is None else (element.text or "").strip()
