"""URDF: a robot as ROS has it, read into the plain tree (http://wiki.ros.org/urdf/XML, ros/urdfdom@jazzy).

What urdfdom refuses is refused, and so is what it passes silently although it cannot be meant: misspelt words, a
second element where one is taken, links with two parents. What is legal and has no word in the language is kept as it
stands. A comment goes with the entry of the tree that it stands before or in.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Publisher, Robot
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.link import NO_SOURCE
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Source, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.xml.files import printable_name
from rosorin_compile.source.xml.markup import COMMENT, Document, Element, MarkupError, Remark, parse

from ..checked import accept, lower_artifact
from ..imported import BEFORE, BESIDE, END, INSIDE, Comment, Imported, ReadOptions
from .grammar import CHILDREN, attributes
from .joints import read_joint
from .links import read_link
from .materials import read_materials, settle
from .reading import NAME, Reading, put
from .values import shortened

RULES = (
    Rule(
        "not-expanded",
        "A warning: a value holds `${...}` or `$(...)`, as a xacro has before it is expanded.",
        "Name the file `NAME.xacro`.",
        READING,
    ),
)


_PUBLISHER = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
_NOT_PRINTED = re.compile("[\x00-\x1f\x7f]")
_VERSIONS = ("1", "1.0", "1.1", "1.2")


def read_urdf(document: Document, path: Path, options: ReadOptions, files: tuple[Path, ...] = ()) -> Imported:
    """Return the robot of a URDF document. ``files`` are the files that it was made of; if empty, ``path`` alone."""
    reading = Reading(options)
    root = document.root
    tree = _tree(root, path, reading)
    diagnostics = reading.all_diagnostics()
    files = files or (path,)
    version = root.get("version")
    left_out = reading.left_out()
    if has_errors(diagnostics):
        return Imported(None, diagnostics, (), files, left_out, version)
    accepted, told = accept(tree, options.lenient) if options.checked else (tree, [])
    diagnostics += [_with_way_out(one) for one in told]
    if accepted is None:
        return Imported(None, diagnostics, (), files, left_out, version)
    comments = without_banner(comments_of(document, reading.paths))
    return Imported(accepted, diagnostics, comments, files, left_out, version)


def read(text: str) -> Robot:
    """Return the robot that a URDF of ours contains. Raises ValueError if it is damaged."""
    try:
        document = parse(Source("the URDF", text))
        if document.root.tag != "robot":
            raise ValueError(f"the root element is {document.root.tag}, not robot")
        reading = Reading(ReadOptions(), spelling=False)
        tree = _tree(document.root, Path("robot.urdf"), reading)
    except MarkupError as problem:
        raise ValueError(problem.diagnostic.message) from None
    return _without_springs(plain(lower_artifact(tree, reading.diagnostics)))


def _without_springs(robot: Robot) -> Robot:
    """Return a robot without the springs that ``_springs`` found: its <gazebo> elements have them already."""
    joints = []
    for joint in robot.joints:
        if joint.dynamics is not None:
            dynamics = replace(joint.dynamics, stiffness=0.0, spring_reference=0.0)
            joint = replace(joint, dynamics=dynamics if dynamics != Dynamics() else None)
        joints.append(joint)
    return replace(robot, joints=tuple(joints))


def plain(robot: Robot) -> Robot:
    """Return a robot without what no URDF and no SDF says: where it is from, and who publishes its joints.

    Raises ValueError if a joint has an end that is no link.
    """
    for joint in robot.joints:
        for end in ("parent", "child"):
            if getattr(joint, end) not in robot.link:
                raise ValueError(f'the {end} of the joint "{joint.name}" is no link: "{getattr(joint, end)}"')
    joints = tuple(replace(joint, publisher=_PUBLISHER) for joint in robot.joints)
    return replace(robot, source=NO_SOURCE, joints=joints, outputs=())


def _with_way_out(diagnostic: Diagnostic) -> Diagnostic:
    """Return what a rule says of a mimic of nobody with what ``_mimic`` does leniently."""
    if diagnostic.rule != "mimic-unknown":
        return diagnostic
    return replace(diagnostic, help=f"{diagnostic.help}; --lenient leaves the mimic out")


def _tree(root: Element, path: Path, reading: Reading) -> Map:
    """Return the plain tree of <robot>."""
    tree = Map(root.span)
    _robot_name(root, path, tree, reading)
    source = Map(root.span)
    put(source, "status", "imported", root)
    put(source, "note", f"from {printable_name(path)}", root)
    put(tree, "source", source, root)
    reading.paths[id(root)] = ("robot",)
    materials = read_materials(root, reading)
    if materials is not None:
        tree.put("materials", materials, materials.span, materials.span)
    reading.joints = frozenset(child.get("name") for child in root.children if child.tag == "joint")
    _section(root, "link", read_link, tree, reading)
    _section(root, "joint", read_joint, tree, reading)
    settle(tree, reading)
    reading.check(root, CHILDREN["robot"], attributes("robot"), tree)
    _springs(root, tree)
    version = root.attributes.get("version")
    if version is not None and version.value.strip() not in _VERSIONS:
        reading.cannot_carry(f'the version "{version.value}" of <robot>', version.span, "URDF has 1.0, 1.1 and 1.2")
    _not_expanded(root, reading)
    if "links" not in tree and not has_errors(reading.diagnostics):
        reading.error("no-links", f'the robot "{tree.get("robot")}" has no links', root.span, 'add <link name="..."/>')
    return tree


def _springs(root: Element, tree: Map) -> None:
    """Give joints the springs that <gazebo> elements have for them, which other simulators know as well."""
    for block in root.children if "joints" in tree else ():
        joint = tree["joints"].get(block.get("reference")) if block.tag == "gazebo" else None
        if not isinstance(joint, Map):
            continue
        for element in block.children:
            key = _SPRING.get(element.tag)
            try:
                value = float(element.get("value") or element.text)
            except ValueError:
                continue
            if key is not None and isinstance(joint, Map) and math.isfinite(value):
                dynamics = joint.setdefault("dynamics", Map(element.span))
                joint.key_spans.setdefault("dynamics", element.span)
                joint.value_spans.setdefault("dynamics", element.span)
                dynamics.put(key, value, element.span, element.span)


_SPRING = {"springStiffness": "stiffness", "springReference": "spring_reference"}


def _not_expanded(root: Element, reading: Reading) -> None:
    """Warn of a file that looks like xacro that nobody expanded."""
    text = root.document.source.text
    if "${" not in text and "$(" not in text:
        return
    for element in root.iter():
        if element.tag.startswith("xacro:"):  # told already
            continue
        for attribute in element.attributes.values():
            if "${" in attribute.raw or "$(" in attribute.raw:
                message = f"{shortened(attribute.raw)} looks like xacro that was not expanded"
                help = "name the file NAME.xacro, or declare xmlns:xacro in <robot>"
                reading.diagnostics.append(Diagnostic("not-expanded", WARNING, message, attribute.span, (), help))
                return


def _robot_name(root: Element, path: Path, tree: Map, reading: Reading) -> None:
    attribute = root.attributes.get("name")
    if attribute is not None and attribute.value.strip():
        name, problem = attribute.value, ""
        if not NAME.match(name):
            _bad_name("robot", attribute.value, root, reading)
        tree.put("robot", name, attribute.name_span, attribute.span)
        return
    problem = '<robot> lacks the attribute "name"' if attribute is None else "the name of <robot> is empty"
    if reading.lenient("missing-attribute", problem, root.span, 'add name="..."', "takes the name of the file"):
        stem = re.sub(r"[^\w.-]+", "_", path.name.split(".")[0]) or "robot"
        tree.put("robot", stem, root.span, root.span)


def _section(
    root: Element, tag: str, read: Callable[[Element, TreePath, Reading], Map], tree: Map, reading: Reading
) -> None:
    """Set the section of links or of joints, if there are any."""
    section: Map | None = None
    for number, element in enumerate(root.children):
        Progress.step(f"reading {tag}s", number, len(root.children))
        if element.tag != tag:
            continue
        section = Map(element.span) if section is None else section
        name = _name(element, reading)
        path: TreePath = (f"{tag}s", name or "")
        reading.paths[id(element)] = path
        entry = read(element, path, reading)
        if name is None:
            continue
        attribute = element.attributes["name"]
        if name in section:
            related = [Related("first defined here", section.key_spans[name])]
            message = f'the {tag} "{name}" is defined twice'
            reading.error("duplicate-name", message, attribute.span, "rename or remove one", related)
            continue
        section.put(name, entry, attribute.span, element.span)
    if section is not None:
        tree.put(f"{tag}s", section, section.span, section.span)


def _name(element: Element, reading: Reading) -> str | None:
    name = reading.attribute(element, "name")
    if name is not None and not NAME.match(name):
        _bad_name(element.tag, name, element, reading)
    return name


def _bad_name(kind: str, name: str, element: Element, reading: Reading) -> None:
    """Report a name that no entry of a description can have."""
    span = element.attributes["name"].span
    if not name.strip():
        reading.error("bad-name", f"the name of a {kind} is empty", span, "give it a name")
        return
    why = "begins or ends with a space" if name != name.strip() else "has one of < > & \" ' or a control character"
    reading.error("bad-name", f'the name of the {kind} "{_NOT_PRINTED.sub("?", name)}" {why}', span, "rename it")


# What xacro writes above the file that it makes, a comment a line.
_RULE = "=+"
_BANNER = (_RULE, r"\|\s+This document was autogenerated by xacro from .*\|", r"\|\s+EDITING THIS FILE BY .*\|", _RULE)
_SHAPES = ("visual", "collision")
# A comment, the path that it belongs to, and where (see ``Comment``).
_Found = tuple[Remark, TreePath, str]


def without_banner(comments: list[Comment]) -> list[Comment]:
    """Return comments without the banner of xacro: it warns of edits, which a description is made for."""
    for start in range(len(comments) - len(_BANNER) + 1):
        lines = comments[start : start + len(_BANNER)]
        if all(re.fullmatch(form, line.text.strip()) for form, line in zip(_BANNER, lines, strict=True)):
            return [*comments[:start], *comments[start + len(_BANNER) :]]
    return comments


def comments_of(document: Document, paths: Mapping[int, TreePath]) -> list[Comment]:
    """Return the comments of a document, in their order.

    ``paths`` leads from an element (by ``id``) to what became of it. Comments within an element that was kept as it
    stands are part of it and do not appear here.
    """
    comments: list[_Found] = [(remark, ("robot",), BEFORE) for remark in _comments(document.before)]
    waiting: list[tuple[Element, TreePath]] = [(document.root, paths.get(id(document.root), ()))]
    while waiting:
        element, path = waiting.pop()
        comments += _within(document, element, path, paths)
        read = [(child, paths[id(child)]) for child in element.children if id(child) in paths]
        waiting += [(child, inner) for child, inner in read if "urdf_elements" not in inner]
    comments += [(remark, (), END) for remark in _comments(document.after)]
    in_order = sorted(comments, key=lambda found: found[0].start)
    return [Comment(one.text, document.span(one.start, one.end - one.start), path, how) for one, path, how in in_order]


def _comments(remarks: list[Remark]) -> Iterator[Remark]:
    return (remark for remark in remarks if remark.kind == COMMENT)


def _within(document: Document, element: Element, path: TreePath, paths: Mapping[int, TreePath]) -> Iterator[_Found]:
    """Yield the comments directly in an element."""
    text = document.source.text
    content = element.content
    for index, item in enumerate(content):
        if isinstance(item, Element) or item.kind != COMMENT:
            continue
        before = content[index - 1] if index else None
        above = before
        while isinstance(above, Remark) and index:
            index -= 1
            above = content[index - 1] if index else None
        same_line = above is not None and "\n" not in text[above.end : item.start]
        after = next((other for other in content[content.index(item) :] if isinstance(other, Element)), None)
        if above is None and element.tag in _SHAPES and after is not None:  # it speaks of the shape, not of its origin
            yield item, path, BEFORE
        elif same_line and isinstance(above, Element):
            yield item, paths.get(id(above), path), BESIDE
        elif (
            above is None
            and "\n" not in text[element.opened : item.start]
            and "\n" in text[item.end : _next(item, content, element)]
        ):
            yield item, path, BESIDE
        elif after is not None:
            yield item, paths.get(id(after), path), BEFORE
        else:
            yield item, path, INSIDE


def _next(item: Remark, content: list[Element | Remark], element: Element) -> int:
    """Return where the first thing behind a remark begins, the end of the element at the latest."""
    later = [other.start for other in content if other.start >= item.end]
    return later[0] if later else element.end
