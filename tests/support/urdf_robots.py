"""URDFs that the writer makes of robots, and their elements."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from typing import Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.model import Output, Robot


def emit(robot: Robot, options: Mapping[str, Any] | None = None) -> str:
    options = {"number_format": "exact", **(options or {})}
    text, diagnostics = urdf.write(robot, Output("urdf", "urdf", "robot.urdf", options), Templates())
    assert diagnostics == []
    return text


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)


def link(text: str, name: str) -> ElementTree.Element:
    return next(element for element in parsed(text).iter("link") if element.get("name") == name)


def numbers(text: str | None) -> list[float]:
    return [float(token) for token in (text or "").split(" ")]
