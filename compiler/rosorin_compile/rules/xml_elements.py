"""Elements of XML that a description carries for the URDF: each text is elements, whole and well formed.

The links and joints that they name are there, by their final names, with every prefix. Who reads such an element passes
over a name that it does not know: Gazebo keeps its default friction, a controller waits for a joint that never comes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from ..diagnostics import WARNING, Diagnostic, Related, nearest
from ..diagnostics.registry import NUMBERS, rule
from ..frontend.tree import Path
from ..model import ROBOT_STATE_PUBLISHER
from ..xml.elements import Found, damage, found_in
from .case import Case, suggest
from .kinematics import WORLD_FRAMES

AFTER = "materials"

LINK, JOINT, EITHER = "link", "joint", "link or joint"

# What has none of these words names no link and no joint.
_WORDS = ("link", "Link", "joint", "Joint", "reference", "mimic", "body")
# Elements whose <link name> and <joint name> are links and joints of the robot: those of an SRDF and of ros2_control.
_REFERRING = (
    *("chain", "disable_collisions", "disable_collision", "disable_default_collisions", "enable_collisions"),
    *("end_effector", "group", "group_state", "passive_joint", "ros2_control", "transmission"),
)
# Attributes that name a link or a joint, whatever the element.
_ATTRIBUTES = dict.fromkeys(("link", "link1", "link2", "base_link", "tip_link", "parent_link", "child_link"), LINK)
_ATTRIBUTES |= dict.fromkeys(("joint", "joint1", "joint2"), JOINT)
# The text of an element of a plug-in that says so is a name, if it is nearly one of the robot.
_TEXTS = (
    (re.compile(r"(.*_)?joint|joint_?[nN]ame|.+Joint"), JOINT),
    (re.compile(r"(.*_)?link|(link|body)_?[nN]ame|.+Link"), LINK),
)
_PLAIN = re.compile(r"[\w./-]+")
_MAX_RELATED = 3


@rule(
    "bad-xml",
    "A text of `urdf_elements` is not whole elements of XML.",
    "Correct it as the message says.",
    NUMBERS,
)
def well_formed(case: Case) -> Iterator[Diagnostic]:
    """Texts that would make the URDF unreadable, or would end the element that they stand in."""
    for path, texts in _kept(case):
        for index, text in enumerate(texts):
            wrong = damage(text)
            if wrong:
                help = "write whole elements, such as <gazebo>...</gazebo>"
                message = f"this is no element of XML: {wrong}"
                yield case.problem("bad-xml", message, (*path, "urdf_elements", index), help)


def _kept(case: Case) -> Iterator[tuple[Path, Sequence[str]]]:
    """Yield the texts of each entry that has any, with its path."""
    robot = case.robot
    yield (), robot.urdf_elements
    for link in robot.links:
        yield case.link(link.name), link.urdf_elements
        for purpose in ("visual", "collision"):
            for index, shape in enumerate(getattr(link, purpose)):
                yield case.link(link.name, purpose, index), shape.urdf_elements
    for joint in robot.joints:
        yield case.joint(joint), joint.urdf_elements


class Mention(NamedTuple):
    """A name in an element: of what kind, where, in words, and the line of the text. ``sure``: it can be no other."""

    name: str
    kind: str
    where: str
    line: int
    path: Path
    sure: bool = True


@rule(
    "unknown-reference",
    "A warning: an element of `urdf_elements` names a link or a joint that there is not, or that the URDF has not. Its "
    "readers pass over it.",
    "Correct the name.",
    NUMBERS,
)
def known(case: Case) -> Iterator[Diagnostic]:
    """Names inside kept elements that no link or joint has; each name once, however often it stands there."""
    mentions: dict[tuple[str, str], list[Mention]] = {}
    own: set[str] = set()
    for path, kept in _kept(case):
        for index, text in enumerate(kept):
            if any(word in text for word in _WORDS):
                for element in found_in(text):
                    own.update(_defined(element))
                    for mention in _mentions(element, (*path, "urdf_elements", index)):
                        mentions.setdefault((mention.kind, mention.name), []).append(mention)
    if mentions:
        yield from _unknown(case, mentions, own)


def _unknown(case: Case, mentions: dict[tuple[str, str], list[Mention]], own: set[str]) -> Iterator[Diagnostic]:
    robot = case.robot
    links = {*robot.link, *WORLD_FRAMES, "world", *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    names = {LINK: links, JOINT: set(robot.joint), EITHER: {*robot.link, *robot.joint}}
    real = {**names, LINK: set(robot.link)}
    absent = _absent_from_urdf(case)
    for (kind, name), uses in mentions.items():
        if name in own:
            continue
        sure = [use for use in uses if use.sure]
        if name in names[kind]:
            if name in absent and sure:
                yield _not_in_urdf(case, sure)
        elif sure or nearest(name, names[kind]):
            message = f'there is no {kind} "{name}", {(sure or uses)[0].where}'
            yield _problem(case, message, sure or uses, suggest(name, real[kind], f"name a {kind} of the robot"))


def _absent_from_urdf(case: Case) -> set[str]:
    """Return the links and joints that are not in the URDF, because another node publishes them."""
    carried = case.robot.in_urdf()
    if not carried or not case.feeding(ROBOT_STATE_PUBLISHER):
        return set()
    inside = {name for joint in carried for name in (joint.name, joint.parent, joint.child)}
    return {*case.robot.link, *case.robot.joint} - inside


def _not_in_urdf(case: Case, uses: list[Mention]) -> Diagnostic:
    use = uses[0]
    what = "link" if use.name in case.robot.link and use.kind != JOINT else "joint"
    message = f'the URDF has no {what} "{use.name}", {use.where}: robot_state_publisher does not publish it'
    return _problem(case, message, uses, "let robot_state_publisher publish it, or remove the element")


def _problem(case: Case, message: str, uses: list[Mention], help: str) -> Diagnostic:
    first, *others = [_placed(case, message, use, help) for use in uses[: _MAX_RELATED + 1]]
    related = tuple(Related("also named here", other.span) for other in others)
    return first._replace(related=(*related, *first.related))


def _placed(case: Case, message: str, use: Mention, help: str) -> Diagnostic:
    """Return the diagnostic at the very name, where the file has it as it is: below the beginning of the text."""
    made = case.problem("unknown-reference", message, use.path, help, severity=WARNING)
    if made.span is None:
        return made
    form = re.compile(rf"(?<![\w./-]){re.escape(use.name)}(?![\w./-])")
    span, column = made.span, made.span.column - 1
    block = span.source.line(span.line)[column : column + 1] in ("|", ">")  # in YAML, its text begins a line below
    line = span.line + use.line - (0 if block else 1)
    found = form.search(span.source.line(line), column if line == span.line else 0)
    if found:
        return made._replace(span=span._replace(line=line, column=found.start() + 1, length=len(use.name)))
    return made


def _defined(element: Found) -> Iterator[str]:
    """Yield the name that an element gives a link or joint of its own, as SDF within <gazebo> does."""
    name = element.attributes.get("name")
    if name and element.tags[0] not in _REFERRING and element.tags[-1] in ("link", "joint", "body", "virtual_joint"):
        yield name


def _mentions(element: Found, path: Path) -> Iterator[Mention]:
    """Yield the names of links and joints in an element."""
    tag, top = element.tags[-1], element.tags[0]
    for kind, attribute in _named(element):
        name = element.attributes.get(attribute, "").strip()
        if _is_name(name):
            inside = f" in <{top}>" if len(element.tags) > 1 else ""
            where = f"the {attribute} of <{tag}>{inside}"
            yield Mention(name, kind, where, element.line, path, top != "mujoco")
    if tag == "param" and element.attributes.get("name") == "mimic" and top == "ros2_control":
        if _is_name(element.text):
            yield Mention(element.text, JOINT, 'the param "mimic" in <ros2_control>', element.line, path)
        return
    kind = _kind_of_text(tag) if element.text else ""
    if kind and _is_name(element.text):
        yield Mention(element.text, kind, f"the text of <{tag}> in <{top}>", element.line, path, sure=False)


@lru_cache(maxsize=2_000)
def _kind_of_text(tag: str) -> str:
    """Return what the text of an element of this tag names: a link, a joint, or neither."""
    return next((kind for form, kind in _TEXTS if form.fullmatch(tag)), "")


def _named(element: Found) -> Iterator[tuple[str, str]]:
    """Yield the attributes of an element that name a link or a joint, with the kind of what they name."""
    tag, top = element.tags[-1], element.tags[0]
    if tag == "gazebo" and len(element.tags) == 1:
        yield EITHER, "reference"
    if top in _REFERRING and tag in ("link", "joint", "passive_joint"):
        yield LINK if tag == "link" else JOINT, "name"
    for attribute in element.attributes:
        if attribute in _ATTRIBUTES:
            yield _ATTRIBUTES[attribute], attribute


def _is_name(text: str) -> bool:
    """Say whether a text can be the name of a link or joint: one word, and none that xacro has yet to expand."""
    return bool(_PLAIN.fullmatch(text)) and not _is_number(text)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return text.lower() in ("true", "false")
    return True
