"""Read a URDF into the tree of a description (http://wiki.ros.org/urdf/XML, ros/urdfdom@jazzy).

What urdfdom refuses is refused, and so is what it accepts silently although it cannot be right: misspelt words, a
second element where one is taken, links with two parents. What is legal and has no key in the language is kept as it
is written. A comment goes with the entry of the tree that follows it or contains it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Publisher, Robot, Transform
from rosorin_compile.model.link import NO_SOURCE
from rosorin_compile.source.diagnostics import (
    WARNING,
    Diagnostic,
    Related,
    Source,
    Span,
    did_you_mean,
    has_errors,
)
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.wording import and_more, counted, listed, plural, quoted
from rosorin_compile.source.xml.files import printable_name
from rosorin_compile.source.xml.markup import COMMENT, Document, Element, MarkupError, Remark, Word, parse

from ..imported import BEFORE, BESIDE, END, INSIDE, Comment, Imported, ReadOptions
from ..reading import accept, lower_artifact
from .reading import (
    JOINT_PARTS,
    NAME,
    NUMBERS,
    PLAIN,
    SHAPES,
    TYPES,
    Reading,
    attributes,
    check_element,
    named,
    number_of,
    numbers,
    put,
    put_all,
    put_numbers,
    shortened,
)

RULES = (
    Rule(
        "not-expanded",
        "A warning: a value holds `${...}` or `$(...)`, as a xacro has before it is expanded.",
        "Name the file `NAME.xacro`.",
        READING,
    ),
    Rule("missing-element", "An element lacks another that the specification asks for.", "Add it.", READING),
    Rule("import-kept", "A note: a shape of another kind is kept as it is.", topic=READING),
    Rule("joint-type", "URDF has no such type of joint.", "Correct it.", READING),
    Rule("zero-quaternion", "A quaternion is zero, which is no rotation.", "Correct it.", READING),
    Rule("import-converted", "A note: the same is said in another form.", topic=READING),
)

_PUBLISHER = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
_NOT_PRINTED = re.compile("[\x00-\x1f\x7f]")
_NOT_IN_MATERIALS = re.compile(r"[<>&\"'\x00-\x1f]")
_VERSIONS = ("1", "1.0", "1.1", "1.2")
_SPRING = {"springStiffness": "stiffness", "springReference": "spring_reference"}
_PRODUCTS = ("ixy", "ixz", "iyz")
# The types of joints that have ends, whose numbers have units.
_LIMITED = ("revolute", "prismatic")
# What has no effect on a joint of a type. That of an axis is not reported: exporters write one for every joint.
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}


def read_urdf(document: Document, path: Path, options: ReadOptions, files: tuple[Path, ...] = ()) -> Imported:
    """Return the robot of a URDF document. ``files`` are the files that it was made of; if empty, ``path`` alone."""
    reading = Reading(options)
    tree: Map | None = _tree(document.root, path, reading)
    diagnostics = reading.all_diagnostics()
    if tree is not None and has_errors(diagnostics):
        tree = None
    elif tree is not None and options.checked:
        tree, problems = accept(tree, options.lenient)
        diagnostics += [
            replace(one, help=f"{one.help}; --lenient leaves the mimic out") if one.rule == "mimic-unknown" else one
            for one in problems
        ]
    comments = without_banner(comments_of(document, reading.paths)) if tree is not None else []
    version = document.root.get("version")
    return Imported(tree, diagnostics, comments, files or (path,), reading.left_out(), version)


def read(text: str) -> Robot:
    """Return the robot that a URDF of ours contains. Raises ValueError if it is damaged."""
    try:
        document = parse(Source("the URDF", text))
        if document.root.tag != "robot":
            raise ValueError(f"the root element is {document.root.tag}, not robot")
        reading = Reading(ReadOptions(), spelling=False)
        tree = _tree(document.root, Path("robot.urdf"), reading, springs=False)  # <gazebo> elements have them
    except MarkupError as problem:
        raise ValueError(problem.diagnostic.message) from None
    return plain(lower_artifact(tree, reading.diagnostics))


def plain(robot: Robot) -> Robot:
    """Return a robot without what no URDF and no SDF contains: sources, and publishers of joints.

    Raises ValueError if a joint has an end that is no link.
    """
    for joint in robot.joints:
        for end in ("parent", "child"):
            if getattr(joint, end) not in robot.link:
                raise ValueError(f'the {end} of the joint "{joint.name}" is no link: "{getattr(joint, end)}"')
    joints = tuple(replace(joint, publisher=_PUBLISHER) for joint in robot.joints)
    return replace(robot, source=NO_SOURCE, joints=joints, outputs=())


def _tree(root: Element, path: Path, reading: Reading, springs: bool = True) -> Map:
    """Return the tree of <robot>."""
    tree = Map(root.span)
    _robot_name(root, path, tree, reading)
    source = Map(root.span)
    put(source, "status", "imported", root)
    put(source, "note", f"from {printable_name(path)}", root)
    put(tree, "source", source, root)
    reading.paths[id(root)] = ("robot",)
    _materials(root, tree, reading)
    reading.joints = frozenset(child.get("name") for child in root.children if child.tag == "joint")
    _section(root, "link", _link, tree, reading)
    _section(root, "joint", _joint, tree, reading)
    _rename_materials(tree, reading)
    check_element(root, reading, tree)
    if springs:
        _springs(root, tree)
    version = root.attributes.get("version")
    if version is not None and version.value.strip() not in _VERSIONS:
        reading.cannot_carry(f'the version "{version.value}" of <robot>', version.span, "URDF has 1.0, 1.1 and 1.2")
    _not_expanded(root, reading)
    if "links" not in tree and not has_errors(reading.diagnostics):
        reading.error("no-links", f'the robot "{tree.get("robot")}" has no links', root.span, 'add <link name="..."/>')
    return tree


def _robot_name(root: Element, path: Path, tree: Map, reading: Reading) -> None:
    attribute = root.attributes.get("name")
    if attribute is not None and attribute.value.strip():
        _check_name(root, reading)
        tree.put("robot", attribute.value, attribute.name_span, attribute.span)
        return
    problem = '<robot> lacks the attribute "name"' if attribute is None else "the name of <robot> is empty"
    if reading.lenient("missing-attribute", problem, root.span, 'add name="..."', "takes the name of the file"):
        stem = re.sub(r"[^\w.-]+", "_", path.name.split(".")[0]) or "robot"
        tree.put("robot", stem, root.span, root.span)


def _check_name(element: Element, reading: Reading) -> str | None:
    """Return the name of an element, after an error if no entry of a description can have it."""
    name = reading.attribute(element, "name")
    if name is None or NAME.match(name):
        return name
    span = element.attributes["name"].span
    if not name.strip():
        reading.error("bad-name", f"the name of a {element.tag} is empty", span, "give it a name")
    else:
        why = "begins or ends with a space" if name != name.strip() else "has one of < > & \" ' or a control character"
        message = f'the name of the {element.tag} "{_NOT_PRINTED.sub("?", name)}" {why}'
        reading.error("bad-name", message, span, "rename it")
    return name


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
        name = _check_name(element, reading)
        path: TreePath = (f"{tag}s", name or "")
        reading.paths[id(element)] = path
        entry = read(element, path, reading)
        if name is None:
            continue
        span = element.attributes["name"].span
        if name in section:
            related = [Related("first defined here", section.key_spans[name])]
            message = f'the {tag} "{name}" is defined twice'
            reading.error("duplicate-name", message, span, "rename or remove one", related)
            continue
        section.put(name, entry, span, element.span)
    if section is not None:
        tree.put(f"{tag}s", section, section.span, section.span)


def _springs(root: Element, tree: Map) -> None:
    """Give joints the springs that <gazebo> elements have for them, which other simulators know as well."""
    for block in root.children if "joints" in tree else ():
        joint = tree["joints"].get(block.get("reference")) if block.tag == "gazebo" else None
        for element in block.children if isinstance(joint, Map) else ():
            key = _SPRING.get(element.tag)
            try:
                value = float(element.get("value") or element.text)
            except ValueError:
                continue
            if key is not None and isinstance(joint, Map) and math.isfinite(value):
                joint.setdefault_at("dynamics", Map(element.span), element.span)
                joint["dynamics"].put(key, value, element.span, element.span)


def _not_expanded(root: Element, reading: Reading) -> None:
    """Warn of a file that looks like xacro that was not expanded."""
    text = root.document.source.text
    if "${" not in text and "$(" not in text:
        return
    for element in root.iter():
        for attribute in () if element.tag.startswith("xacro:") else element.attributes.values():
            if "${" in attribute.raw or "$(" in attribute.raw:
                message = f"{shortened(attribute.raw)} looks like xacro that was not expanded"
                help = "name the file NAME.xacro, or declare xmlns:xacro in <robot>"
                reading.diagnostics.append(Diagnostic("not-expanded", WARNING, message, attribute.span, (), help))
                return


def _link(element: Element, path: TreePath, reading: Reading) -> Map:
    """Return the entry of a <link>."""
    entry = Map(element.span)
    inertial = reading.single(element, "inertial")
    if inertial is not None:
        _inertial(inertial, entry, path, reading)
    for purpose in ("visual", "collision"):
        for child in element.children:
            if child.tag == purpose:
                _shape(child, entry, path, reading)
    check_element(element, reading, entry)
    return entry


def _inertial(element: Element, link: Map, path: TreePath, reading: Reading) -> None:
    """Set the inertial of a link; mass and all six moments are required, as in urdfdom.

    Leniently, an unreadable one is left out, as urdfdom does, and missing products are 0.
    """
    entry = Map(element.span)
    reading.paths[id(element)] = (*path, "inertial")
    before = len(reading.diagnostics)
    parts = {tag: reading.single(element, tag) for tag in ("mass", "inertia")}
    for tag, part in parts.items():
        if part is not None:
            reading.paths[id(part)] = (*path, "inertial", tag)
        elif reading.options.lenient:
            reading.cannot_carry(f"{named(element)}, which lacks <{tag}>,", element.span)
        else:
            message = f"{named(element)} lacks <{tag}>"
            help = f"add <{tag}>, or remove <inertial> of a frame without mass; --lenient leaves the inertial out"
            reading.error("missing-element", message, element.span, help)
    mass, inertia = parts.values()
    if mass is not None:
        check_element(mass, reading)
        reading.need(mass, "value")
        put_numbers(entry, mass, "value", reading, "mass")
    _origin(entry, element, (*path, "inertial"), reading)
    if inertia is not None:
        put(entry, "inertia", _inertia(inertia, reading), inertia)
    check_element(element, reading)
    if mass is not None and inertia is not None and not reading.spoilt(element, "the inertial", before):
        put(link, "inertial", entry, element)


def _inertia(element: Element, reading: Reading) -> Map:
    """Return the moments of an <inertia>."""
    moments, names = Map(element.span), [*NUMBERS["inertia"]]
    for name in ("iyx", "izx", "izy"):
        if name in element.attributes and element.get(name) == element.get(f"i{name[2]}{name[1]}"):
            reading.ignored("iyx, izx and izy of <inertia> say again what ixy, ixz and iyz say", element.span)
            names.append(name)
    reading.check(element, (), names, None)
    missing = reading.missing(element, *NUMBERS["inertia"])
    put_all(moments, element, reading)
    if missing and all(name in _PRODUCTS for name in missing):
        message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
        help = "add " + " ".join(f'{name}="0"' for name in missing) + ", if that is meant"
        if reading.lenient("missing-attribute", message, element.span, help, "takes 0"):
            for name in missing:
                moments.put(name, 0, element.span, element.span)
    else:
        reading.need(element, *missing)
    return moments


def _shape(element: Element, link: Map, path: TreePath, reading: Reading) -> None:
    """Add a <visual> or a <collision> to its list; kept whole where the language has no key for its geometry."""
    geometry = reading.single(element, "geometry")
    if geometry is None:
        message = f"{named(element)} has no <geometry>"
        if reading.lenient("missing-element", message, element.span, "add one, or remove it", "keeps it as it is"):
            reading.keep(element, link)
        return
    entry = Map(element.span)
    shape = _geometry(geometry, entry, reading)
    if shape is None:
        return
    if shape is geometry:
        what = listed(f"<{child.tag}>" for child in geometry.children)
        message = f"{what} of {named(element)} is a shape of its own kind: kept as it is"
        reading.note("import-kept", message, geometry.span)
        reading.keep(element, link)
        return
    name = element.attributes.get("name")
    if name is not None and NAME.match(name.value):
        entry.put("name", name.value, name.name_span, name.span)
    elif name is not None and name.value:
        reading.cannot_carry(f"the name {shortened(name.value)} of <{element.tag}>", name.span)
    if element.tag not in link:
        put(link, element.tag, Seq(element.span), element)
    own = (*path, element.tag, len(link[element.tag]))
    reading.paths[id(element)] = own
    reading.paths[id(geometry)] = reading.paths[id(shape)] = (*own, shape.tag)
    _origin(entry, element, own, reading)
    material = reading.single(element, "material") if element.tag == "visual" else None
    if material is not None:
        reading.paths[id(material)] = (*own, "material")
        called = _material_name(material, reading)
        if called:
            attribute = material.attributes["name"]
            entry.put("material", called, attribute.name_span, attribute.span)
        _surface(entry, material, reading)
    check_element(element, reading, entry)
    link[element.tag].put(entry, element.span)


def _geometry(geometry: Element, entry: Map, reading: Reading) -> Element | None:
    """Set the shape of an entry and return its element: None after an error, the geometry if it is unknown."""
    shapes = [child for child in geometry.children if child.tag in SHAPES]
    if len(shapes) > 1:
        message = f"{named(geometry)} has {listed(f'<{child.tag}>' for child in shapes)}; it takes one"
        reading.error("duplicate-element", message, shapes[1].span, "make a second <visual> or <collision> of it")
        return None
    if not shapes and geometry.children:
        before = len(reading.diagnostics)
        check_element(geometry, reading, Map(geometry.span))
        return None if has_errors(reading.diagnostics[before:]) else geometry
    if not shapes:
        message = f"{named(geometry)} is empty"
        reading.error("missing-element", message, geometry.span, f"it takes one of {', '.join(SHAPES)}")
        return None
    check_element(geometry, reading)
    shape = shapes[0]
    made = Map(shape.span)
    check_element(shape, reading)
    if shape.tag == "mesh":
        file = reading.attribute(shape, "filename")
        if file is not None:
            attribute = shape.attributes["filename"]
            made.put("file", file, attribute.name_span, attribute.span)
            if not file.strip():
                message = f"filename of {named(shape)} is empty"
                reading.error("missing-attribute", message, attribute.span, "name a mesh")
        words = shape.attributes["scale"].words() if "scale" in shape.attributes else []
        if len(words) == 1:
            _other_count(made, shape, "scale", reading, "give 3", "takes it for all three", words * 3)
        elif len(words) > 3:
            _other_count(made, shape, "scale", reading, "give 3", "takes the first three", words[:3])
        else:
            put_numbers(made, shape, "scale", reading)
    else:
        reading.need(shape, *attributes(shape.tag))
        put_all(made, shape, reading)
    put(entry, shape.tag, made, shape)
    return shape


def _other_count(
    entry: Map, element: Element, name: str, reading: Reading, help: str, instead: str, words: list[Word], *more: float
) -> None:
    """Set a list of numbers that has another length than URDF says: of some of its words, and ``more`` numbers."""
    attribute = element.attributes[name]
    all_words = attribute.words()
    values = {word: number_of(word, PLAIN, element, name, reading) for word in all_words}
    count = NUMBERS[element.tag][name][0]
    message = f"{name} of {named(element)} has {counted(len(all_words), 'number')}; it takes {count}"
    if None in values.values() or not reading.lenient("wrong-count", message, attribute.span, help, instead):
        return
    made = Seq(attribute.span)
    for value, word in (*((values[word], word) for word in words), *((number, words[-1]) for number in more)):
        made.put(value, word.span)
    entry.put(name, made, attribute.name_span, attribute.span)


def _origin(entry: Map, element: Element, path: TreePath, reading: Reading) -> None:
    """Set ``xyz`` and ``rpy`` of an entry from the <origin> in an element."""
    origin = reading.single(element, "origin")
    if origin is None:
        return
    check_element(origin, reading)
    reading.paths[id(origin)] = (*path, "xyz" if "xyz" in origin.attributes else "rpy")
    put_numbers(entry, origin, "xyz", reading)
    attribute = origin.attributes.get("quat_xyzw")
    if attribute is None:
        put_numbers(entry, origin, "rpy", reading)
        return
    if "rpy" in origin.attributes:
        message = f"{named(origin)} has rpy and quat_xyzw; readers differ in which of them they take"
        reading.error("duplicate-element", message, attribute.name_span, "remove one")
        return
    quaternion = numbers(origin, "quat_xyzw", 4, PLAIN, reading)
    if quaternion is None:
        return
    if not any(quaternion):
        message = f"quat_xyzw of {named(origin)} is zero: no rotation"
        reading.error("zero-quaternion", message, attribute.span, "correct it")
        return
    x, y, z, w = quaternion
    made = Seq(attribute.span)
    for angle in Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rpy():
        made.put(angle + 0.0, attribute.span)
    entry.put("rpy", made, attribute.name_span, attribute.span)
    reading.note("import-converted", f"quat_xyzw of {named(origin)} became rpy: the same rotation", attribute.span)


def _joint(element: Element, path: TreePath, reading: Reading) -> Map:
    """Return the entry of a <joint>."""
    entry, kind = Map(element.span), reading.attribute(element, "type") or ""
    if "type" in element.attributes:
        attribute = element.attributes["type"]
        if kind in TYPES:
            entry.put("type", kind, attribute.name_span, attribute.span)
        else:
            message = f'{named(element)} is of type "{kind}", which URDF does not have'
            help = did_you_mean(kind, TYPES).replace("known:", "it has")
            reading.error("joint-type", message, attribute.span, help)
            kind = ""
    reading.magnitudes.types.add(kind)
    for end in ("parent", "child"):
        inner = reading.single(element, end)
        if inner is None:
            help = f'add <{end} link="..."/>'
            reading.error("missing-element", f"{named(element)} has no <{end}>", element.span, help)
            continue
        check_element(inner, reading)
        reading.paths[id(inner)] = (*path, end)
        _reference(inner, "link", entry, end, reading)
    _origin(entry, element, path, reading)
    position = TYPES[kind] if kind in _LIMITED else PLAIN
    for tag in JOINT_PARTS:
        part = reading.single(element, tag)
        if part is None:
            continue
        reading.paths[id(part)] = (*path, tag)
        if tag not in _WITHOUT_EFFECT.get(kind, ()):
            _joint_part(part, entry, position, reading)
        elif tag != "axis":
            reading.ignored(f"<{tag}> of a {kind} joint has no effect", part.span)
    if kind in _LIMITED and "limit" not in entry and reading.single(element, "limit") is None:
        help = 'add <limit lower="" upper="" effort="" velocity=""/>'
        help += ", or make it continuous" if kind == "revolute" else ""
        message = f"{named(element)} is {kind} and has no <limit>"
        reading.lenient("limit-missing", message, element.span, help, "takes it without")
    check_element(element, reading, entry)
    return entry


def _reference(element: Element, name: str, entry: Map, key: str, reading: Reading) -> None:
    """Set a key to the link or the joint that an attribute names."""
    value = reading.attribute(element, name)
    if value is None:
        return
    attribute = element.attributes[name]
    entry.put(key, value, attribute.name_span, attribute.span)
    if not value:
        reading.error("missing-attribute", f"{name} of {named(element)} is empty", attribute.span, f"name a {name}")


def _joint_part(element: Element, joint: Map, position: str, reading: Reading) -> None:
    """Set the key of a joint that one of its elements has; ``position`` is the unit of the joint's position."""
    tag, entry = element.tag, Map(element.span)
    check_element(element, reading)
    if tag == "axis":
        if reading.attribute(element, "xyz") is not None:
            put_numbers(joint, element, "xyz", reading, "axis")
        if "axis" in joint:
            joint.key_spans["axis"] = element.span
        return
    if tag == "mimic":
        leader = reading.attribute(element, "joint")
        if leader is None:
            return
        if leader and leader not in reading.joints and reading.options.lenient:
            reading.cannot_carry(named(element), element.span, "the joint that it follows is not there")
            return
        _reference(element, "joint", entry, "joint", reading)
    # Readers of URDF take a missing bound for 0.
    put_all(entry, element, reading, position, zero=("lower", "upper") if position and tag == "limit" else ())
    if tag == "limit":
        missing = [name for name in ("effort", "velocity") if name not in element.attributes]
        if missing:
            message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
            help = "add them, the largest torque or force and the largest speed: readers of URDF refuse a limit without"
            reading.lenient("limit-incomplete", message, element.span, help, "takes it without")
    elif tag == "dynamics" and not NUMBERS["dynamics"].keys() & element.attributes.keys():
        message = f"{named(element)} has neither damping nor friction"
        help = "add one, or remove the element: urdfdom, the reader of ROS, refuses the joint"
        reading.lenient("missing-attribute", message, element.span, help, "leaves it out")
        return
    elif tag == "calibration" and not entry:
        reading.ignored("<calibration> without a value has no effect", element.span)
        return
    elif tag == "safety_controller":
        reading.need(element, "k_velocity")
    put(joint, tag, entry, element)


def _materials(robot: Element, tree: Map, reading: Reading) -> None:
    """Set the section of materials, if <robot> has some."""
    made: Map | None = None
    for element in robot.children:
        if element.tag != "material":
            continue
        name = _material_name(element, reading)
        if not name:
            if name is not None:
                reading.cannot_carry("a material of the robot without a name", element.span)
            continue
        made = Map(element.span) if made is None else made
        entry = Map(element.span)
        _surface(entry, element, reading)
        if name not in made:
            reading.paths[id(element)] = ("materials", name)
            made.put(name, entry, element.attributes["name"].span, element.span)
        elif reading.options.lenient:
            reading.cannot_carry(f'a second material "{name}"', element.span, "the first is taken")
        else:
            related, help = [Related("the first", made.value_spans[name])], "remove one; --lenient takes the first"
            reading.error("duplicate-name", f'the material "{name}" is defined twice', element.span, help, related)
    if made is not None:
        tree.put("materials", made, made.span, made.span)


def _material_name(element: Element, reading: Reading) -> str | None:
    """Return the name of a material, as a description can have it; None after an error."""
    name = reading.attribute(element, "name")
    clean = None if name is None else " ".join(_NOT_IN_MATERIALS.sub("_", name).split())
    if clean != name:
        message = f'the material "{name}" is called "{clean}": a name has no markup and no spaces around it'
        reading.note("import-changed", message, element.attributes["name"].span)
    return clean


def _surface(entry: Map, element: Element, reading: Reading) -> None:
    """Set rgba and texture of an entry."""
    color = reading.single(element, "color")
    if color is not None:
        check_element(color, reading)
        before = len(reading.diagnostics)
        if reading.attribute(color, "rgba") is not None:
            words = color.attributes["rgba"].words()
            if len(words) == 3:
                help = "add the opacity: 1 hides what is behind"
                _other_count(entry, color, "rgba", reading, help, "takes an opacity of 1", words, 1)
            else:
                put_numbers(entry, color, "rgba", reading)
        reading.spoilt(color, "the colour", before)
    texture = reading.single(element, "texture")
    if texture is not None:
        check_element(texture, reading)
        attribute = texture.attributes.get("filename")
        if attribute is not None and attribute.value:
            entry.put("texture", attribute.value, attribute.name_span, attribute.span)
        else:  # exporters write an empty <texture/>
            reading.ignored("a texture without a file name has no effect", texture.span)
    check_element(element, reading)


def _rename_materials(tree: Map, reading: Reading) -> None:
    """Remove the name of each material of a visual that looks otherwise than the first material of that name.

    A name has one meaning in a URDF: urdfdom takes the first for all, other readers what is written in the visual.
    """

    def look(entry: Map) -> tuple[object, object]:
        rgba = entry.get("rgba")
        return (None if rgba is None else tuple(map(float, rgba)), entry.get("texture"))

    materials = (tree.get("materials") or {}).items()
    looks = {name: look(entry) for name, entry in materials if "rgba" in entry or "texture" in entry}
    others: list[tuple[str, Span]] = []
    for name, link in (tree.get("links") or {}).items():
        for visual in link.get("visual", ()):
            if "material" not in visual or not ("rgba" in visual or "texture" in visual):
                continue
            if looks.setdefault(visual["material"], look(visual)) != look(visual):
                others.append((f'the material "{visual["material"]}" of link "{name}"', visual.value_spans["material"]))
                del visual["material"]
    if others:
        (what, span), *more = others
        message = f"{what} looks otherwise than the first of that name, which ROS takes for all: it keeps its look and"
        message += " loses the name" + (f",{and_more(len(more), 'of this kind')}" if more else "")
        reading.note("import-changed", message, span)


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
