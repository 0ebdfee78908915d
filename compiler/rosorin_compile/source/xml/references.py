"""References: where elements of XML in a URDF or an SRDF name a link or a joint of the robot.

``references`` yields them, sure ones and those that may be one; ``renamed`` returns elements with other names there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

from ..diagnostics import Source
from .elements import found_in

LINK, JOINT, EITHER, FRAME = "link", "joint", "link or joint", "frame"

# Elements whose <link name> and <joint name> are links and joints of the robot: those of an SRDF and of ros2_control.
REFERRING = (
    *("chain", "disable_collisions", "disable_collision", "disable_default_collisions", "enable_collisions"),
    *("end_effector", "group", "group_state", "passive_joint", "ros2_control", "transmission"),
)
# Attributes that name a link or a joint, whatever the element.
_ATTRIBUTES = dict.fromkeys(("link", "link1", "link2", "base_link", "tip_link", "parent_link", "child_link"), LINK)
_ATTRIBUTES |= dict.fromkeys(("joint", "joint1", "joint2"), JOINT)
# The text of an element of a plug-in that says so is a name, if it is nearly one of the robot.
_TEXTS = (
    (r"(.*_)?joint|joint_?[nN]ame|.+Joint", JOINT),
    (r"(.*_)?link|(link|body)_?[nN]ame|.+Link", LINK),
    (r"(.*_)?frame(_id|_name)?|frame(Id|Name)|.+Frame(Id|Name)?", FRAME),
)


class Reference(NamedTuple):
    """A name of what kind: the value of an attribute, or the text of an element where ``attribute`` is empty.

    ``where`` says it in words. ``sure``: it can be no other name.
    """

    name: str
    kind: str
    attribute: str
    where: str
    sure: bool = True


def references(tags: tuple[str, ...], attributes: Mapping[str, str], text: str) -> Iterator[Reference]:
    """Yield the names in one element: the ``tags`` that lead to it, its own last, its attributes, its own text."""
    tag, top = tags[-1], tags[0]
    for kind, attribute in _named(tags, attributes):
        name = attributes.get(attribute, "").strip()
        if _is_name(name):
            inside = f" in <{top}>" if len(tags) > 1 else ""
            yield Reference(name, kind, attribute, f"the {attribute} of <{tag}>{inside}", top != "mujoco")
    if tag == "param" and attributes.get("name") == "mimic" and top == "ros2_control":
        if _is_name(text):
            yield Reference(text, JOINT, "", 'the param "mimic" in <ros2_control>')
        return
    kind = _kind_of_text(tag) if text else ""
    if kind and _is_name(text):
        yield Reference(text, kind, "", f"the text of <{tag}> in <{top}>", sure=False)


Finder = Callable[[tuple[str, ...], Mapping[str, str], str], Iterator[Reference]]


def named_in(text: str) -> Iterator[Reference]:
    """Yield the names in some elements; none of what is no XML."""
    for element in found_in(text):
        yield from references(element.tags, element.attributes, element.text)


def _named(tags: tuple[str, ...], attributes: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield the attributes of an element that name a link or a joint, after the kind of what they name."""
    tag, top = tags[-1], tags[0]
    if tag == "gazebo" and len(tags) == 1:
        yield EITHER, "reference"
    if top in REFERRING and tag in ("link", "joint", "passive_joint"):
        yield LINK if tag == "link" else JOINT, "name"
    for attribute in attributes:
        if attribute in _ATTRIBUTES:
            yield _ATTRIBUTES[attribute], attribute


@lru_cache(maxsize=2_000)
def _kind_of_text(tag: str) -> str:
    return next((kind for form, kind in _TEXTS if re.fullmatch(form, tag)), "")


def _is_name(text: str) -> bool:
    """Say whether a text can be the name of a link or joint: one word, and none that xacro has yet to expand."""
    return bool(re.fullmatch(r"[\w./-]+", text)) and not _is_number(text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text.lower() in ("true", "false")
    return True


def renamed(text: str, rename: Callable[[str], str], references: Finder = references) -> str:
    """Return elements in which each name is what ``rename`` makes of it; all else is as it was.

    ``references`` yields the names in one element; by default those of links and joints.
    """
    from .markup import TEXT, MarkupError, Remark, parse

    before = "<robot>"
    try:
        document = parse(Source("", f"{before}{text}</robot>"))
    except MarkupError:  # the rules say what is wrong
        return text
    places: list[tuple[int, str, str]] = []
    above: dict[int, tuple[str, ...]] = {id(document.root): ()}
    for element in document.root.iter():
        tags = (*above[id(element.parent)], element.tag) if element.parent is not None else ()
        above[id(element)] = tags
        if not tags:
            continue
        plain = {name: one.value for name, one in element.attributes.items() if one.raw == one.value}
        texts = [one for one in element.content if isinstance(one, Remark) and one.kind == TEXT]
        alone = texts[0] if len(element.content) == 1 and texts else None
        for found in references(tags, plain, alone.text.strip() if alone else ""):
            name = rename(found.name)
            start = element.attributes[found.attribute].start if found.attribute else alone.start if alone else -1
            if name != found.name and start >= 0:
                form = re.compile(rf"(?<![^\s\"'>]){re.escape(found.name)}(?![^\s\"'<])")
                there = form.search(document.source.text, start)
                places += [(there.start(), found.name, name)] if there else []
    made = document.source.text
    for start, old, new in sorted(set(places), reverse=True):
        made = made[:start] + new + made[start + len(old) :]
    return made[len(before) : -len("</robot>")]
