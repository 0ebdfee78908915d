"""Names of links and joints in elements of XML of a URDF or an SRDF."""

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
    """A name in the value of an attribute, or in the text of an element if ``attribute`` is empty.

    ``where`` is the place in words. Without ``sure`` the text may be something else than a name.
    """

    name: str
    kind: str
    attribute: str
    where: str
    sure: bool = True


def references(tags: tuple[str, ...], attributes: Mapping[str, str], text: str) -> Iterator[Reference]:
    """Yield the names in one element, given the ``tags`` that lead to it, its own last, its attributes and text."""
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
    """Yield the kind and the attribute of each name of a link or a joint."""
    if tags == ("gazebo",):
        yield EITHER, "reference"
    if tags[0] in REFERRING and tags[-1] in ("link", "joint", "passive_joint"):
        yield LINK if tags[-1] == "link" else JOINT, "name"
    yield from ((_ATTRIBUTES[attribute], attribute) for attribute in attributes if attribute in _ATTRIBUTES)


@lru_cache(maxsize=2_000)
def _kind_of_text(tag: str) -> str:
    return next((kind for form, kind in _TEXTS if re.fullmatch(form, tag)), "")


def _is_name(text: str) -> bool:
    """Return True if a text can be the name of a link or joint: one word, no number or flag, no xacro expression."""
    if not re.fullmatch(r"[\w./-]+", text) or text.lower() in ("true", "false"):
        return False
    try:
        float(text)
    except ValueError:
        return True
    return False


def renamed(text: str, rename: Callable[[str], str], references: Finder = references) -> str:
    """Return elements in which each name that ``references`` yields is replaced by ``rename`` of it."""
    from .markup import TEXT, MarkupError, Remark, parse

    before, after = "<robot>", "</robot>"
    try:
        document = parse(Source("", f"{before}{text}{after}"))
    except MarkupError:  # the rules report it
        return text
    made = document.source.text
    places: set[tuple[int, str, str]] = set()
    tags_of: dict[int, tuple[str, ...]] = {id(document.root): ()}
    for element in [*document.root.iter()][1:]:
        tags = tags_of[id(element)] = (*tags_of[id(element.parent)], element.tag)
        plain = {name: one.value for name, one in element.attributes.items() if one.raw == one.value}
        only = element.content[0] if len(element.content) == 1 else None
        inner = only if isinstance(only, Remark) and only.kind == TEXT else None
        for found in references(tags, plain, inner.text.strip() if inner else ""):
            name = rename(found.name)
            start = element.attributes[found.attribute].start if found.attribute else inner.start if inner else -1
            if name != found.name and start >= 0:
                form = re.compile(rf"(?<![^\s\"'>]){re.escape(found.name)}(?![^\s\"'<])")
                if there := form.search(made, start):
                    places.add((there.start(), found.name, name))
    for start, old, new in sorted(places, reverse=True):
        made = made[:start] + new + made[start + len(old) :]
    return made[len(before) : -len(after)]
