"""Elements of XML where nobody reads them: in the wrong parent, without a reference, or in none of SDF's words."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Help, Suggestion
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.wording import listed
from rosorin_compile.source.xml.elements import Found, found_in

from .case import Case
from .xml_elements import at_name, kept_texts


class Place(NamedTuple):
    """Where an element is read: in these parents, by this reader."""

    parents: tuple[str, ...]
    reader: str


# The elements of a URDF that a reader takes from one place alone.
READ_IN: Mapping[str, Place] = {
    "ros2_control": Place(("robot",), "ros2_control"),
    "gazebo": Place(("robot",), "Gazebo"),
    "transmission": Place(("robot",), "ros_control"),
    "hardware": Place(("ros2_control",), "ros2_control"),
    "command_interface": Place(("joint", "gpio", "sensor"), "ros2_control"),
    "state_interface": Place(("joint", "gpio", "sensor"), "ros2_control"),
}
# What Gazebo reads in a <gazebo> that refers to a link or a joint (gazebosim/sdformat: src/parser_urdf.cc).
_OF_LINKS = (
    *("mu1", "mu2", "fdir1", "kp", "kd", "maxVel", "minDepth", "maxContacts", "laserRetro", "material"),
    *("turnGravityOff", "dampingFactor", "visual", "collision"),
)
_OF_JOINTS = (
    *("springStiffness", "springReference", "stopCfm", "stopErp", "fudgeFactor", "initialJointPosition"),
    *("implicitSpringDamper", "provideFeedback", "preserveFixedJoint", "disableFixedJointLumping", "cfmDamping"),
)
REFERRING = (*_OF_LINKS, *_OF_JOINTS, "sensor")
# What Gazebo reads in a <gazebo>, and nobody in these elements of a URDF.
_OF_GAZEBO, _OF_URDF = ("sensor", "plugin"), ("robot", "link", "joint", "visual", "collision")
# What an <sdf> of an entry holds, by where the entry is.
_CONTENTS = {"robot": "model"}
_FREE = ("plugin", "script", "shader", "meta")  # their contents are their own


@cache
def sdf_elements() -> Mapping[str, frozenset[str]]:
    """Return the elements of SDF by their parent, of all versions that are read."""
    text = files.read_text(data_folder("schemas") / "sdf_elements.json")
    return {parent: frozenset(children) for parent, children in json.loads(text)["elements"].items()}


@rule(
    "misplaced-element",
    "A warning: an element of `urdf_elements` is where its reader does not look for it, or no element of SDF.",
    "Move it where the message says, or correct its name.",
    NUMBERS,
)
def misplaced(case: Case) -> Iterator[Diagnostic]:
    """Elements that nobody reads, each with the place where its reader looks."""
    for path, text in kept_texts(case):
        holder = _holder(path)
        waiting: list[tuple[Found, str, Help]] = []
        for element in found_in(text):
            tags = (holder, *element.tags)
            wrong = _misplaced(tags)
            if wrong:
                waiting.append((element, *wrong))
            elif tags[-2] == "gazebo" and tags[-1] in REFERRING:
                waiting.append((element, "", f"Gazebo reads <{tags[-1]}> of a link or a joint"))
            if len(element.tags) > 1:
                continue
            name = element.attributes.get("reference", "")
            kind, words = _wrong_words(case, name)
            for found, message, help in waiting:
                if message:
                    yield _at(case, path, found, message, help)
                elif not name:
                    message = f"nobody reads <{found.tags[-1]}> in a <gazebo> without a reference"
                    yield _at(case, path, found, message, f'{help}: <gazebo reference="NAME">')
                elif found.tags[-1] in words:
                    message = f'nobody reads <{found.tags[-1]}> in a <gazebo> that refers to the {kind} "{name}"'
                    other = "joint" if kind == "link" else "link"
                    yield _at(case, path, found, message, f"Gazebo reads it of a {other}: refer to one")
            waiting = []
    for name, sensor in (case.tree.get("sensors") or {}).items():
        entries = sensor.get("gazebo") if isinstance(sensor, Map) else None
        for index, entry in enumerate(entries if isinstance(entries, list) else ()):
            yield from _words(case, ("sensors", name, "gazebo", index, "elements"), entry.get("elements"), "sensor")


def _wrong_words(case: Case, name: str) -> tuple[str, tuple[str, ...]]:
    """Return what a name refers to, and the words that Gazebo does not read there."""
    is_link, is_joint = name in case.robot.link, name in case.robot.joint
    if is_link == is_joint:
        return "", ()
    return ("link", _OF_JOINTS) if is_link else ("joint", _OF_LINKS)


def _holder(path: Path) -> str:
    """Return the element of a URDF that the elements at a path stand in."""
    if path[0] in ("links", "joints"):
        purposes = [str(step) for step in path if step in ("visual", "collision")]
        return purposes[0] if purposes else str(path[0]).removesuffix("s")
    return "robot"


def _misplaced(tags: tuple[str, ...]) -> tuple[str, Help] | None:
    """Return what is wrong with the place of an element, and what to do; None if nothing is known to be."""
    *_, parent, tag = tags
    if any(one in _FREE for one in tags[:-1]) or ":" in "".join(tags[1:]):
        return None
    place = READ_IN.get(tag)
    outside = "transmission" not in tags[:-1] and "sdf" not in tags[:-1]
    if place is not None and parent not in place.parents and outside:
        where = listed([f"<{one}>" for one in place.parents])
        return f"nobody reads <{tag}> in <{parent}>", f"{place.reader} reads it in {where}: move it there"
    if tag in _OF_GAZEBO and parent in _OF_URDF and not {"gazebo", "sdf", "transmission"} & set(tags):
        return f"nobody reads <{tag}> in <{parent}>", 'Gazebo reads it in <gazebo reference="LINK">: move it there'
    top = next((index for index, one in enumerate(tags[:-1]) if one in ("sdf", "sensor")), None)
    if top is None or "ros2_control" in tags[:-1] or "transmission" in tags:
        return None
    inside = _CONTENTS.get(tags[top - 1], tags[top - 1]) if parent == "sdf" else parent
    known = sdf_elements().get(inside)
    if known is None or tag in known:
        return None
    return f"SDF has no <{tag}> in <{inside}>", Suggestion(tag, known, none="correct it, or remove it")


def _words(case: Case, path: Path, elements: Any, parent: str) -> Iterator[Diagnostic]:
    """Yield what is no element of SDF among those of a sensor."""
    known = sdf_elements().get(parent)
    if not isinstance(elements, Map) or known is None:
        return
    for name, value in elements.items():
        if name in _FREE or ":" in name or name == "attributes" or value is None:
            continue
        if name not in known:
            help = Suggestion(name, known, none="correct it, or remove it")
            message = f"SDF has no <{name}> in <{parent}>"
            yield case.problem("misplaced-element", message, (*path, name), help, severity=WARNING, key=True)
        else:
            yield from _words(case, (*path, name), value, name)


def _at(case: Case, path: Path, element: Found, message: str, help: Help) -> Diagnostic:
    made = case.problem("misplaced-element", message, path, help, severity=WARNING)
    return at_name(made, element.tags[-1], element.line)
