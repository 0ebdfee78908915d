"""Rules about raw XML: snippets must be well-formed, and names and parents of URDF elements must be valid.

Programs silently ignore elements that refer to unknown names: Gazebo uses its default friction, or a controller waits
forever for a missing joint.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from rosorin_compile.language.element_names import EITHER, FRAME, JOINT, LINK, REFERRING, Reference, references
from rosorin_compile.language.schema import named_as
from rosorin_compile.language.symbols import Symbol
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Joint, Link, Shape
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Source, Suggestion, nearest
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.wording import phrase, suggest
from rosorin_compile.source.xml.elements import canonical, damage, found_in, tree_of

from .case import Case
from .joints import WORLD_FRAMES

_MAX_SUGGESTED = 3
_AROUND = "urdf_elements"  # tag that is wrapped around a snippet to parse it; a snippet does not contain this tag
_CLOSES = r"</(.+)> does not close <(.+)>"


def urdf_texts(case: Case) -> Iterator[tuple[Path, str]]:
    """Yield (path, XML snippet) for each item of ``urdf_elements`` of the robot, its joints, links and shapes."""
    robot = case.robot
    for index, text in enumerate(robot.urdf_elements):
        yield case.places.get(("urdf_element", str(index)), ("urdf_elements", index)), text
    owners: list[tuple[Path, Joint | Link | Shape]] = []
    owners += [(case.joint(joint), joint) for joint in robot.joints if joint.urdf_elements]
    for link in robot.links:
        if link.urdf_elements or any(shape.urdf_elements for shape in (*link.visual, *link.collision)):
            owners += [(case.link(link.name), link), *((path, shape) for _, path, shape in case.shapes(link))]
    for path, owner in owners:
        yield from (((*path, "urdf_elements", index), text) for index, text in enumerate(owner.urdf_elements))


def mjcf_texts(case: Case) -> Iterator[tuple[Path, str, bool]]:
    """Yield (path, XML snippet, is_top_level) for each item of ``mjcf`` (top level) and ``mjcf_elements``."""
    for index, text in enumerate(case.robot.mjcf):
        yield ("mjcf", index), text, True
    for link in case.robot.links:
        for index, text in enumerate(link.mjcf_elements):
            yield case.link(link.name, "mjcf_elements", index), text, False


@rule("bad-xml", help="Write complete elements, such as `<gazebo>...</gazebo>`.", topic=NUMBERS)
def well_formed(case: Case) -> Iterator[Diagnostic]:
    """An item of `urdf_elements`, `mjcf` or `mjcf_elements` does not consist of complete XML elements."""
    from rosorin_compile.source.xml.markup import MarkupError, parse

    for path, text in (*urdf_texts(case), *((path, text) for path, text, _ in mjcf_texts(case))):
        reason, line, column, help = damage(text), 0, 0, ""
        if not reason:
            continue
        try:
            parse(Source("", f"<{_AROUND}>{text}</{_AROUND}>"))
        except MarkupError as problem:
            reason, span, help = problem.diagnostic.message, problem.diagnostic.span, problem.diagnostic.help
            line, column = (span.line, span.column) if span else (1, 1)
            column -= len(_AROUND) + 2 if line == 1 else 0
            left = re.fullmatch(_CLOSES, reason)
            if left and left[1] == _AROUND:  # a child element is not closed
                reason, line, help = f"<{left[2]}> is not closed", 0, f"add </{left[2]}>"
            elif left and left[2] == _AROUND:
                reason, help = f"</{left[1]}> closes an element that is not open", f"remove </{left[1]}>"
        made = case.problem("bad-xml", f"not an XML element: {reason}", path, help)
        wrong = text.split("\n")[line - 1] if line else ""
        moved = at_name(made, wrong.strip(), line) if wrong.strip() else made
        if moved.span is not None and moved is not made:
            right = max(0, column - 1 - (len(wrong) - len(wrong.lstrip())))
            moved = replace(moved, span=moved.span._replace(column=moved.span.column + right, length=1))
        yield moved


def at_name(made: Diagnostic, name: str, number: int) -> Diagnostic:
    """Return a diagnostic moved to ``name`` in line ``number`` of its XML snippet, or unchanged if not found."""
    if made.span is None:
        return made
    span, column = made.span, made.span.column - 1
    is_block = span.source.line(span.line)[column : column + 1] in ("|", ">")  # a block scalar begins one line below
    line = span.line + number - (0 if is_block else 1)
    form = re.compile(rf"(?<![\w./-]){re.escape(name)}(?![\w./-])")
    found = form.search(span.source.line(line), column if line == span.line else 0)
    return replace(made, span=span._replace(line=line, column=found.start() + 1, length=len(name))) if found else made


@rule("unknown-reference", help="Correct the name.", topic=NUMBERS)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """A warning: `urdf_elements` names a link, joint or material that does not exist or is not in the URDF."""
    mentions: dict[tuple[str, str], list[tuple[Reference, Path, int]]] = {}
    own: set[str] = set()
    materials = {*case.robot.material, *(shape.material for link in case.robot.links for shape in link.visual)}
    for path, text in urdf_texts(case):
        described = False  # True if the next <material> has a colour or texture; children precede their parent
        for element in found_in(text):
            tags, name = element.tags, element.attributes.get("name")
            named = list(references(tags, element.attributes, element.text))
            if name and tags[0] not in REFERRING and tags[-1] in ("link", "joint", "body", "virtual_joint"):
                own.add(name)  # SDF elements within <gazebo> define names, too
            if tags[-2:] in (("material", "color"), ("material", "texture")):
                described = True
            elif tags[0] != "gazebo" and tags[-1] == "material" and name:  # materials in <gazebo> are Gazebo's
                materials |= {name} if described else set()
                named.append(Reference(name, "material", "name", "the name of <material>"))
                described = False
            for attribute in element.attributes if tags == ("gazebo",) else ():
                if attribute != "reference" and nearest(attribute, ["reference"]):
                    message = f'<gazebo> has no attribute "{attribute}", so it applies to the entire robot'
                    problem = case.problem("unknown-reference", message, path, suggest("reference"))
                    yield at_name(problem, attribute, element.line)
            for one in named:
                mentions.setdefault((one.kind, one.name), []).append((one, path, element.line))
    mentions = {key: uses for key, uses in mentions.items() if key[1] not in own}
    robot, both = case.robot, {*case.robot.link, *case.robot.joint}
    links = {*robot.link, *WORLD_FRAMES, "world", *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    names = {LINK: links, JOINT: {*robot.joint}, FRAME: links, "material": materials, EITHER: both}
    carried = robot.in_urdf() if mentions and case.outputs_read_by(ROBOT_STATE_PUBLISHER) else ()
    inside = {name for joint in carried for name in (joint.name, joint.parent, joint.child)}
    for (kind, name), uses in mentions.items():
        sure = [use for use in uses if use[0].sure]
        _, path, line = (sure or uses)[0]
        if name not in names[kind] and (sure or nearest(name, names[kind])):
            message, uses = f'there is no {kind} "{name}"', sure or uses
            real = {*robot.link} if kind in (LINK, FRAME) else names[kind]
            help: Help = case.suggest(path, name, real, f"use a {kind} of the robot")
            # Prefer names that only have an additional prefix, which a part may have added.
            longer = sorted(one for one in real if one.endswith(name) and not one[: -len(name)][-1:].isalnum())
            help = suggest(*longer[:_MAX_SUGGESTED]) if longer else help
        elif kind != "material" and carried and sure and name not in inside and name in both:
            what = "link" if name in robot.link and kind != JOINT else "joint"
            message, uses = f'the {what} "{name}" is not in the URDF', sure
            help = "let robot_state_publisher publish it, or remove the element"
        else:
            continue
        texts: dict[Path, Symbol] = {}
        for one, path, _ in uses:
            texts.setdefault(path, Symbol(kind, name, path, what=one.where))
        found = case.unknown("unknown-reference", message, [*texts.values()], help)
        yield from (at_name(one, name, line) for one in found)


@rule("duplicate-xml", help="Rename one of them; in a part, begin the name with `${prefix}`.", topic=NUMBERS)
def duplicates(case: Case) -> Iterator[Diagnostic]:
    """A warning: two elements of `urdf_elements` have the same name, so programs use only one of them."""
    first: dict[tuple[str, ...], Path] = {}
    for section in named_as("hardware block"):
        first |= {("<ros2_control>", name): (section, name) for name in case.section(section)}
    has_gazebo = any(output.options.get("gazebo") for output in case.robot.outputs)
    written = {one.name for sensor in case.robot.sensors for one in sensor.gazebo} if has_gazebo else set()
    for path, text in urdf_texts(case):
        if damage(text):
            continue
        names: list[tuple[str, ...]] = []
        for element in tree_of(f"<all>{text}</all>"):
            if element.tag in ("ros2_control", "transmission"):
                names.append((f"<{element.tag}>", element.get("name", "")))
            for child in element if element.tag == "gazebo" else ():
                # In newer Gazebo, the name of a plug-in is its class, so only equal elements are duplicates.
                same = [canonical(child)] if child.tag == "plugin" and "::" in child.get("name", "") else []
                if child.tag in ("plugin", "sensor"):
                    names.append((f"<{child.tag}>", child.get("name", ""), element.get("reference", ""), *same))
        for what, name, *key in (one for one in names if one[1]):
            before = first.setdefault((what, name, *key), path)
            if what == "<sensor>" and name in written:
                message = f'an output already has a {what} "{name}" for Gazebo, which comes from "sensors"'
                yield case.problem("duplicate-xml", message, path, 'remove it, or write "gazebo: []" in the sensor')
            elif before is not path:
                one, two = case.tree.locate(before), case.tree.locate(path)
                is_same = one.via is not None and one.span == two.span  # the same snippet, because a part is used twice
                related = [Related("the other element", one.via.span if is_same and one.via else one.span)]
                message = f'two {what} elements of the robot have the name "{name}"'
                yield case.problem("duplicate-xml", message, path, related=related)


# URDF elements with the parents in which they are read, and the program that reads them.
_READ_IN: Mapping[str, tuple[tuple[str, ...], str]] = {
    "ros2_control": (("robot",), "ros2_control"),
    "gazebo": (("robot",), "Gazebo"),
    "transmission": (("robot",), "ros_control"),
    "hardware": (("ros2_control",), "ros2_control"),
    **dict.fromkeys(("command_interface", "state_interface"), (("joint", "gpio", "sensor"), "ros2_control")),
}
# Elements that Gazebo reads in a <gazebo> with the attribute "reference" (gazebosim/sdformat: src/parser_urdf.cc).
_OF_LINKS = {
    *("mu1", "mu2", "fdir1", "kp", "kd", "maxVel", "minDepth", "maxContacts", "laserRetro", "material"),
    *("turnGravityOff", "dampingFactor", "visual", "collision"),
}
_OF_JOINTS = {
    *("springStiffness", "springReference", "stopCfm", "stopErp", "fudgeFactor", "initialJointPosition", "cfmDamping"),
    *("implicitSpringDamper", "provideFeedback", "preserveFixedJoint", "disableFixedJointLumping"),
}
# Elements that Gazebo reads only in a <gazebo>, and URDF elements in which they are ignored.
_OF_GAZEBO, _OF_URDF = ("sensor", "plugin"), ("robot", "link", "joint", "visual", "collision")
_FREE = ("plugin", "script", "shader", "meta")  # elements with arbitrary contents, which SDF does not define


@cache
def sdf_elements() -> Mapping[str, list[str]]:
    """Return the SDF elements that each parent element may contain, in any supported version of SDF."""
    data: Any = json.loads(files.read_text(data_folder("schemas") / "sdf_elements.json"))
    return dict(data["elements"])


@rule("misplaced-element", help="Move it where the message says, or correct its name.", topic=NUMBERS)
def misplaced_elements(case: Case) -> Iterator[Diagnostic]:
    """A warning: an element of `urdf_elements` is in a place where programs ignore it, or is not part of SDF."""
    for path, text in urdf_texts(case):
        purposes = [str(step) for step in path if step in ("visual", "collision")]
        holder = purposes[0] if purposes else {"links": "link", "joints": "joint"}.get(str(path[0]), "robot")
        elements = found_in(text)
        for index, element in enumerate(elements):
            # Children precede their parent in the list; only the outermost element has the attribute "reference".
            top = next(one for one in elements[index:] if len(one.tags) == 1)
            if wrong := _misplaced(case, (holder, *element.tags), top.attributes.get("reference", "")):
                made = case.problem("misplaced-element", wrong[0], path, wrong[1])
                yield at_name(made, element.tags[-1], element.line)
    for name, sensor in case.section("sensors").items():
        entries = sensor.get("gazebo") if isinstance(sensor, Map) else None
        for index, entry in enumerate(entries if isinstance(entries, list) else ()):
            path = ("sensors", name, "gazebo", index, "elements")
            yield from _unknown_keys(case, path, entry.get("elements"), "sensor")


def _misplaced(case: Case, tags: tuple[str, ...], reference: str) -> tuple[str, Help] | None:
    *above, parent, tag = tags
    outer = set(tags[:-1])
    if not outer.isdisjoint(_FREE) or ":" in "".join(tags[1:]):
        return None
    unread = f"no program reads <{tag}> in "
    parents, reader = _READ_IN.get(tag, ((parent,), ""))
    if parent not in parents and outer.isdisjoint(("transmission", "sdf")):
        return f"{unread}<{parent}>", f"move it into {phrase(f'<{one}>' for one in parents)}, where {reader} reads it"
    if tag in _OF_GAZEBO and parent in _OF_URDF and not {"gazebo", "sdf", "transmission"} & set(tags):
        return f"{unread}<{parent}>", 'move it into <gazebo reference="LINK">, where Gazebo reads it'
    if parent == "gazebo" and tag in {*_OF_LINKS, *_OF_JOINTS, "sensor"}:
        is_link, is_joint = reference in case.robot.link, reference in case.robot.joint
        if not reference:
            return f"{unread}a <gazebo> without a reference", 'add a link or a joint: <gazebo reference="NAME">'
        if is_link != is_joint and tag in (_OF_JOINTS if is_link else _OF_LINKS):
            kind, other = ("link", "joint") if is_link else ("joint", "link")
            return f'{unread}a <gazebo> that refers to the {kind} "{reference}"', f"refer to a {other}"
    if outer.isdisjoint(("sdf", "sensor")) or "ros2_control" in outer or "transmission" in tags:
        return None
    holder = parent if parent != "sdf" else "model" if above[-1] == "robot" else above[-1]
    known = sdf_elements().get(holder)
    if known is None or tag in known:
        return None
    return f"SDF has no <{tag}> in <{holder}>", Suggestion(tag, known, none="correct it, or remove it")


def _unknown_keys(case: Case, path: Path, elements: Any, parent: str) -> Iterator[Diagnostic]:
    known = sdf_elements().get(parent, [])
    for name, value in elements.items() if isinstance(elements, Map) and known else ():
        if name in known:
            yield from _unknown_keys(case, (*path, name), value, name)
        elif name not in (*_FREE, "attributes") and ":" not in name and value is not None:
            help = Suggestion(name, sorted(known), none="correct it, or remove it")
            yield case.problem("misplaced-element", f"SDF has no <{name}> in <{parent}>", (*path, name), help, key=True)
