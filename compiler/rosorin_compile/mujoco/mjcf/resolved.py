"""Resolved: a file as MuJoCo itself writes it back, every attribute with what classes, frames and units make of it.

MuJoCo's own writer says each element in the words of the format, in radians, with includes, replicas and attached
models in place; and only what differs from its class. Here the classes are resolved as well, so that an element has
all that the file says of it, wherever it says it. It runs in the child process that has MuJoCo, and imports
nothing of the package.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any
from xml.etree import ElementTree

Attributes = dict[str, str]
Node = dict[str, Any]
Element = Any  # xml.etree.ElementTree.Element

# The kinds of objects that a body holds, by the lists of MjSpec, and the tags of their elements.
KINDS = {
    "joints": ("joint", "freejoint"),
    "geoms": ("geom",),
    "sites": ("site",),
    "cameras": ("camera",),
    "lights": ("light",),
}
_LISTED = {"tendons": "tendon", "equalities": "equality", "actuators": "actuator", "sensors": "sensor"}
# Sections that are kept as they are, whole.
_WHOLE = ("extension", "size", "visual", "statistic", "custom", "deformable")
_NO_NAME = "rosorin-compile without name "  # begins the names that nameless objects have while MuJoCo writes
# Attributes of any number of values, which replace those of a class; of all others the first ones do.
_OPEN = ("user", "data", "qpos", "qvel", "act", "ctrl", "mpos", "mquat", "vertex", "face")


def name_all(spec: Any) -> None:
    """Give every object without a name one, by which its element can be found."""
    count = 0
    for kind in (*KINDS, "bodies", "pairs", *_LISTED):
        for thing in getattr(spec, kind):
            if not thing.name and not (kind == "bodies" and thing.parent is None):
                thing.name = f"{_NO_NAME}{count}"
                count += 1


def is_named(name: str) -> bool:
    """Say whether a name is the file's own."""
    return bool(name) and not name.startswith(_NO_NAME)


def without_made_up(message: str) -> str:
    """Return a message of MuJoCo's without the names that nameless objects have while it writes."""
    return re.sub(rf"{_NO_NAME}\d+", "", message)


def resolved(spec: Any) -> dict[str, Any]:
    """Return the elements of a compiled MjSpec, resolved.

    An element is its ``tag``, its ``attributes`` and what stands in it (``inner``). ``bodies`` and the kinds of
    ``KINDS`` are by name; in a body stands here what is of no kind. The sections are lists in the order of the file.
    ``whole`` are the sections that say nothing of bodies and joints.
    """
    if hasattr(spec.compiler, "savecompiled"):  # before MuJoCo 4 it writes six digits
        spec.compiler.savecompiled = False
    return _Resolver(ElementTree.fromstring(spec.to_xml())).made()  # noqa: S314 - MuJoCo's own text


class _Resolver:
    """Reads what MuJoCo has written."""

    def __init__(self, root: Element) -> None:
        self.root = root
        self.classes: dict[str, dict[str, Attributes]] = {}
        for default in root.findall("default"):
            self._class(default, {}, "main")

    def _class(self, default: Element, above: dict[str, Attributes], name: str) -> None:
        own = dict(above)
        for child in default:
            if child.tag != "default":
                own[child.tag] = merged(own.get(child.tag, {}), child.attrib)
        self.classes[default.get("class") or name] = own
        for child in default.findall("default"):
            self._class(child, own, "")

    def attributes(self, element: Element, kind: str, childclass: str) -> Attributes:
        """Return the attributes of an element with those of its class; ``kind`` is what classes call it."""
        usual = self.classes.get(element.get("class") or childclass or "main", {}).get(kind, {})
        made = merged(usual, element.attrib)
        return {key: value for key, value in made.items() if key not in ("class", "childclass")}

    def made(self) -> dict[str, Any]:
        """Return all of it."""
        made: dict[str, Any] = {kind: {} for kind in (*KINDS, "bodies")}
        for world in self.root.findall("worldbody"):
            self._body(world, "world", "", made)
        for word, section in _LISTED.items():
            made[word] = [self._entry(e, section) for part in self.root.findall(section) for e in part]
        made["pairs"] = [self._entry(e, "pair") for part in self.root.findall("contact") for e in part.findall("pair")]
        for tag in ("material", "texture", "mesh", "hfield"):
            found = [self._entry(e, tag) for part in self.root.findall("asset") for e in part.findall(tag)]
            made[f"{tag}_assets"] = found
        made["options"] = self._options()
        made["keys"] = [dict(key.attrib) for part in self.root.findall("keyframe") for key in part]
        made["whole"] = [_node(e, e.attrib) for tag in _WHOLE for e in self.root.findall(tag)]
        return made

    def _options(self) -> Attributes:
        """Return the settings; those of flags as ``flag NAME``."""
        made: Attributes = {}
        for option in self.root.findall("option"):
            made |= option.attrib
            made |= {f"flag {key}": value for flag in option.findall("flag") for key, value in flag.attrib.items()}
        return made

    def _entry(self, element: Element, kind: str) -> Node:
        return _node(element, self.attributes(element, "general" if kind == "actuator" else kind, ""))

    def _body(self, element: Element, name: str, childclass: str, made: dict[str, Any]) -> None:
        held = made["bodies"].setdefault(name, {"tag": "body", "attributes": {}, "inner": []})
        held["attributes"] |= self.attributes(element, "body", "")
        for child, own in self._direct(element, childclass):
            kind = next((kind for kind, tags in KINDS.items() if child.tag in tags), "")
            if child.tag == "body":
                self._body(child, child.get("name", ""), own, made)
            elif kind:
                usual = "" if child.tag == "freejoint" else child.tag
                made[kind][child.get("name", "")] = _node(child, self.attributes(child, usual, own))
            elif child.tag != "inertial":
                held["inner"].append(_node(child, child.attrib))

    def _direct(self, element: Element, childclass: str) -> Iterator[tuple[Element, str]]:
        """Yield what stands in a body itself, frames or not, with the class that holds there."""
        own = element.get("childclass") or childclass
        for child in element:
            if child.tag == "frame":
                yield from self._direct(child, own)
            else:
                yield child, own


def _node(element: Element, attributes: Mapping[str, str]) -> Node:
    """Return an element as plain values; what stands in it is as it is written."""
    own = {key: value for key, value in attributes.items() if key != "name" or is_named(value)}
    return {"tag": element.tag, "attributes": own, "inner": [_node(child, child.attrib) for child in element]}


def merged(usual: Mapping[str, str], own: Mapping[str, str]) -> Attributes:
    """Return the attributes of a class with those of an element over them: of a list as many numbers as it says."""
    made = dict(usual)
    for key, value in own.items():
        words, before = value.split(), made.get(key, "").split()
        few = key not in _OPEN and len(words) < len(before) and _are_numbers([*words, *before])
        made[key] = " ".join([*words, *before[len(words) :]]) if few else value
    return made


def _are_numbers(words: list[str]) -> bool:
    try:
        return all(float(word) is not None for word in words)
    except ValueError:
        return False
