"""Import a URDF as a description (http://wiki.ros.org/urdf/XML, ros/urdfdom@jazzy).

Input that urdfdom rejects is an error, and so are mistakes that it silently accepts: misspelled names, duplicate
elements, links with two parents. Valid elements without a key in descriptions are kept as XML.
"""

import math
import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Publisher, Robot, Transform
from rosorin_compile.model.link import NO_SOURCE
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Span, Suggestion, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.tree import Path as TreePath
from rosorin_compile.source.wording import and_more, mask_controls, phrase
from rosorin_compile.source.xml.markup import Document, Element, name_of, parse_artifact

from ..imported_robot import ImportedRobot, ReadOptions, comments_of
from ..robot_files import accept, lower_artifact
from ..xml_reader import ANGLES, LENGTHS, NAME, PLAIN, XmlReader, lacks, numbers, put_value

# Types of joints, with the unit of the position.
TYPES = {"revolute": "rad", "continuous": "rad", "prismatic": "m", "fixed": "", "floating": "", "planar": "m"}
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
JOINT_PARTS = ("axis", "limit", "mimic", "dynamics", "calibration", "safety_controller")
CHILDREN = {
    "robot": ("link", "joint", "material"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "geometry": SHAPES,
    "material": ("color", "texture"),
    "joint": ("origin", "parent", "child", *JOINT_PARTS),
}
TEXTS = {
    "robot": ("name", "version"),
    "joint": ("name", "type"),
    **dict.fromkeys(("link", "visual", "collision", "material"), ("name",)),
    **dict.fromkeys(("parent", "child"), ("link",)),
    **dict.fromkeys(("mesh", "texture"), ("filename",)),
    "mimic": ("joint",),
}
_POSITION_UNIT = "q"  # stands for the unit of the joint position, rad or m
_LENGTH, _POSITION, _PLAIN = (1, LENGTHS), (1, _POSITION_UNIT), (1, PLAIN)
# Numeric attributes: (number of values, unit). Values with a unit are checked for implausible sizes.
NUMBERS: Mapping[str, Mapping[str, tuple[int, str]]] = {
    "origin": {"xyz": (3, LENGTHS), "rpy": (3, ANGLES), "quat_xyzw": (4, PLAIN)},
    "mass": {"value": _PLAIN},
    "inertia": dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), _PLAIN),
    "box": {"size": (3, LENGTHS)},
    "sphere": {"radius": _LENGTH},
    "cylinder": {"radius": _LENGTH, "length": _LENGTH},
    "capsule": {"radius": _LENGTH, "length": _LENGTH},
    "mesh": {"scale": (3, PLAIN)},
    "color": {"rgba": (4, PLAIN)},
    "axis": {"xyz": (3, PLAIN)},
    "limit": {"lower": _POSITION, "upper": _POSITION, "effort": _PLAIN, "velocity": _PLAIN},
    "mimic": {"multiplier": _PLAIN, "offset": _POSITION},
    "dynamics": {"damping": _PLAIN, "friction": _PLAIN},
    "calibration": dict.fromkeys(("rising", "falling", "reference_position"), _POSITION),
    "safety_controller": dict.fromkeys(("soft_lower_limit", "soft_upper_limit"), _POSITION)
    | dict.fromkeys(("k_position", "k_velocity"), _PLAIN),
}
_ATTRIBUTES = {tag: (*TEXTS.get(tag, ()), *NUMBERS.get(tag, ())) for tag in (*TEXTS, *NUMBERS)}

_PUBLISHER = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
_NOT_PRINTED = "[\x00-\x1f\x7f]"
_NOT_IN_MATERIALS = re.compile(r"[<>&\"'\x00-\x1f]")
_SPRING = {"springStiffness": "stiffness", "springReference": "spring_reference"}
_WITH_RANGE = ("revolute", "prismatic")
# Elements that have no effect for a joint type. Exporters write an axis for all joints, so it is not reported.
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}


def read_urdf(document: Document, path: Path, options: ReadOptions, files: tuple[Path, ...] = ()) -> ImportedRobot:
    """Import a URDF document; ``files`` are the files from which it was generated, by default ``path``."""
    reader = _Reader(options)
    tree: Map | None = reader.robot(document.root, path)
    diagnostics = reader.all_diagnostics()
    if tree is not None and not has_errors(diagnostics) and options.checked:
        tree, problems = accept(tree, options.lenient)
        for one in map(Diagnostic.with_help, problems):
            if one.rule == "mimic-unknown":
                mark = "" if str(one.help).endswith("?") else ";"
                one = replace(one, help=f"{one.help}{mark} --lenient leaves the mimic out")
            diagnostics.append(one)
    tree = None if has_errors(diagnostics) else tree
    comments = comments_of(document, reader.paths) if tree is not None else []
    return ImportedRobot(tree, diagnostics, comments, files or (path,), document.root.get("version"))


def read(text: str) -> Robot:
    """Parse a generated URDF. Raises ValueError if it is damaged."""
    reader = _Reader(ReadOptions(), spelling=False)
    # Springs are compared as <gazebo> elements.
    tree = reader.robot(parse_artifact(text, "robot").root, Path("robot.urdf"), springs=False)
    return plain(lower_artifact(tree, reader.diagnostics))


def plain(robot: Robot) -> Robot:
    """Remove sources and publishers, which a URDF lacks. Raises ValueError if a joint has an unknown link."""
    for joint, end in ((joint, end) for joint in robot.joints for end in ("parent", "child")):
        if (name := getattr(joint, end)) not in robot.link:
            raise ValueError(f'the {end} of the joint "{joint.name}" is not a link: "{name}"')
    joints = tuple(one if one.publisher == _PUBLISHER else replace(one, publisher=_PUBLISHER) for one in robot.joints)
    return replace(robot, source=NO_SOURCE, joints=joints, outputs=())


class _Reader(XmlReader):
    """Converts the elements of a <robot> to the YAML tree of a description."""

    attributes = frozenset(name for table in (TEXTS, NUMBERS) for names in table.values() for name in names)
    joints: Collection[str] = ()  # the names of all joints of the file

    def robot(self, root: Element, path: Path, springs: bool = True) -> Map:
        """Convert a <robot> to a YAML tree; with ``springs``, read joint springs from <gazebo> elements."""
        tree, source = Map(root.span), Map(root.span)
        name = root.attribute("name")
        if name is not None and name.value.strip():
            self._check_name(root)
            tree.put("robot", name.value, name.name_span, name.span)
        else:
            problem = '<robot> lacks the attribute "name"' if name is None else "the name of <robot> is empty"
            if self.lenient("missing-attribute", problem, root.span, 'add name="..."', "uses the name of the file"):
                put_value(tree, "robot", re.sub(r"[^\w.-]+", "_", path.name.split(".")[0]) or "robot", root)
        put_value(source, "status", "imported", root)
        put_value(source, "note", f"from {mask_controls(path.name)}", root)
        put_value(tree, "source", source, root)
        self.paths[id(root)] = ("robot",)
        self._materials(root, tree)
        self.joints = {child.get("name") for child in root.children if child.tag == "joint"}
        self._section(root, "link", self._link, tree)
        self._section(root, "joint", self._joint, tree)
        self._rename_materials(tree)
        self.check_element(root, tree)
        for block in root.children if springs else ():  # springs for Gazebo, which other simulators support, too
            joint: Any = (tree.get("joints") or {}).get(block.get("reference")) if block.tag == "gazebo" else None
            for element in block.children if joint is not None else ():
                with suppress(ValueError):
                    value = float(element.get("value") or element.text)
                    if element.tag in _SPRING and math.isfinite(value):
                        joint.setdefault_at("dynamics", Map(element.span), element.span)
                        put_value(joint["dynamics"], _SPRING[element.tag], value, element)
        version = root.attribute("version")
        if version and version.value.strip() not in ("1", "1.0", "1.1", "1.2"):
            self.cannot_carry(f'the version "{version.value}" of <robot>', version.span, "URDF has 1.0, 1.1 and 1.2")
        every = root.iter() if "$" in root.document.source.text else ()
        values = (value for one in every if not one.tag.startswith("xacro:") for value in one.attributes.values())
        found = next((value for value in values if "${" in value.value or "$(" in value.value), None)
        if found is not None:
            message, help = f'"{found.raw[:40]}" looks like xacro that was not expanded', "name the file NAME.xacro"
            self.diagnostics.append(Diagnostic("not-expanded", WARNING, message, found.span, (), help))
        if "links" not in tree and not has_errors(self.diagnostics):
            self.error("no-links", f'the robot "{tree.get("robot")}" has no links', root.span, 'add <link name="..."/>')
        return tree

    def check_element(self, element: Element, keep: Map | None = None, path: TreePath = (), *needed: str) -> None:
        """Report unknown and missing attributes, and unknown children; record the YAML path of the element."""
        self.check(element, CHILDREN.get(element.tag, ()), _ATTRIBUTES.get(element.tag, ()), keep)
        if needed:
            self.need(element, *needed)
        if path:
            self.paths[id(element)] = path

    def put_numbers(self, entry: Map, element: Element, unit: str = PLAIN, keys: dict[str, str] | None = None) -> None:
        """Copy the numeric attributes of an element to an entry; ``unit`` is the unit of joint positions."""
        for name, (count, own) in NUMBERS[element.tag].items():
            if name not in element.values or (keys is not None and name not in keys):
                continue
            if (made := numbers(element, name, count, unit if own == _POSITION_UNIT else own, self)) is not None:
                span = made.span if count > 1 else made.value_spans[0]
                name_span = element.document.whole or element.attributes[name].name_span
                entry.put(keys[name] if keys else name, made if count > 1 else made[0], name_span, span)

    def _put_text(self, entry: Map, key: str, element: Element, name: str) -> str | None:
        if (value := self.attribute(element, name)) is not None:
            attribute, help = element.attributes[name], f"name a {name.removesuffix('name')}"
            entry.put(key, value, attribute.name_span, attribute.span)
            if not value.strip():
                self.error("missing-attribute", f"{name} of {name_of(element)} is empty", attribute.span, help)
        return value

    def _check_name(self, element: Element) -> str | None:
        name = self.attribute(element, "name")
        if name is None or NAME.match(name):
            return name
        message, help = f"the name of a {element.tag} is empty", "give it a name"
        if name.strip():
            wrong = "contains one of < > & \" ' or a control character"
            wrong = "begins or ends with a space" if name != name.strip() else wrong
            message, help = f'the name of the {element.tag} "{re.sub(_NOT_PRINTED, "?", name)}" {wrong}', "rename it"
        self.error("bad-name", message, element.attributes["name"].span, help)
        return name

    def _section(self, root: Element, tag: str, read: Callable[[Element, TreePath], Map], tree: Map) -> None:
        for number, element in enumerate(root.children):
            Progress.step(f"reading {tag}s", number, len(root.children))
            if element.tag != tag:
                continue
            tree.setdefault_at(f"{tag}s", Map(element.span), element.span)
            section, name = tree[f"{tag}s"], self._check_name(element)
            self.paths[id(element)] = path = (f"{tag}s", name or "")
            entry = read(element, path)
            self.check_element(element, entry)
            span = element.attributes["name"].span if name is not None else element.span
            if name in section:
                related, message = [Related("first defined here", section.key_spans[name])], f'the {tag} "{name}"'
                self.error("duplicate-name", f"{message} is defined twice", span, "rename one of them", related)
            elif name is not None:
                section.put(name, entry, span, element.span)

    def _link(self, element: Element, path: TreePath) -> Map:
        entry = Map(element.span)
        if (inertial := self.single(element, "inertial")) is not None:
            self._inertial(inertial, entry, (*path, "inertial"))
        for child in sorted(element.children, key=lambda child: child.tag != "visual"):
            if child.tag in ("visual", "collision"):
                self._shape(child, entry, path)
        return entry

    def _inertial(self, element: Element, link: Map, path: TreePath) -> None:
        entry, before = Map(element.span), len(self.diagnostics)
        self.paths[id(element)] = path
        for tag in ("mass", "inertia"):
            if (part := self.single(element, tag)) is None:
                help = f"add <{tag}>, or remove <inertial> of a frame without mass"
                self.error("missing-element", f"{name_of(element)} lacks <{tag}>", element.span, help)
            elif tag == "inertia":
                pairs = {"iyx": "ixy", "izx": "ixz", "izy": "iyz"}
                mirrored = [one for one, other in pairs.items() if part.get(one) == part.get(other) != ""]
                if mirrored:
                    self.ignore("iyx, izx and izy of <inertia> repeat ixy, ixz and iyz", part.span)
                self.check(part, (), (*NUMBERS[tag], *mirrored), None)
                self.paths[id(part)], moments = (*path, tag), Map(part.span)
                self.put_numbers(moments, part)
                self.need(part, *NUMBERS[tag])
                put_value(entry, tag, moments, part)
            else:
                self.check_element(part, None, (*path, tag), "value")
                self.put_numbers(entry, part, keys={"value": "mass"})
                self._origin(entry, element, path)
        self.check_element(element)
        if not self.spoilt(element, "the inertial", before):
            put_value(link, "inertial", entry, element)

    def _shape(self, element: Element, link: Map, path: TreePath) -> None:
        """Add a <visual> or <collision> to a link, or keep it as raw XML if its geometry is not supported."""
        geometry = self.single(element, "geometry")
        if geometry is None or not geometry.children:
            message, span = f"{name_of(element)} has no shape in a <geometry>", (geometry or element).span
            if self.lenient("missing-element", message, span, "add one, or remove it", "keeps it as it is"):
                self.keep(element, link)
            return
        shapes, before = [child for child in geometry.children if child.tag in SHAPES], len(self.diagnostics)
        if len(shapes) > 1:
            message = f"{name_of(geometry)} has {phrase(f'<{child.tag}>' for child in shapes)}; it takes one"
            self.error("duplicate-element", message, shapes[1].span, "move one to a second <visual> or <collision>")
            return
        self.check_element(geometry, None if shapes else Map(geometry.span))
        if not shapes and not has_errors(self.diagnostics[before:]):
            what = phrase(f"<{child.tag}>" for child in geometry.children)
            message = f"{what} of {name_of(element)} is not a standard shape: it is kept as XML"
            self.note("import-kept", message, geometry.span)
            self.keep(element, link)
        if not shapes:
            return
        entry, shape, made = Map(element.span), shapes[0], Map(shapes[0].span)
        link.setdefault_at(element.tag, Seq(element.span), element.span)
        own = (*path, element.tag, len(link[element.tag]))
        self.paths[id(element)], self.paths[id(geometry)] = own, (*own, shape.tag)
        self.check_element(shape, None, (*own, shape.tag), *(NUMBERS[shape.tag] if shape.tag != "mesh" else ()))
        if shape.tag == "mesh":
            self._put_text(made, "file", shape, "filename")
        self.put_numbers(made, shape)
        put_value(entry, shape.tag, made, shape)
        name = element.attribute("name")
        if name is not None and NAME.match(name.value):
            entry.put("name", name.value, name.name_span, name.span)
        elif name is not None and name.value:
            self.cannot_carry(f'the name "{name.value[:40]}" of <{element.tag}>', name.span)
        self._origin(entry, element, own)
        material = self.single(element, "material") if element.tag == "visual" else None
        if material is not None:
            self.paths[id(material)] = (*own, "material")
            if called := self._material_name(material):
                attribute = material.attributes["name"]
                entry.put("material", called, attribute.name_span, attribute.span)
            self._look(entry, material)
        self.check_element(element, entry)
        link[element.tag].put(entry, element.span)

    def _origin(self, entry: Map, element: Element, path: TreePath) -> None:
        if (origin := self.single(element, "origin")) is None:
            return
        self.check_element(origin, None, (*path, "xyz" if "xyz" in origin.values else "rpy"))
        attribute = origin.attribute("quat_xyzw")
        self.put_numbers(entry, origin, keys={"xyz": "xyz", **({} if attribute else {"rpy": "rpy"})})
        if attribute is not None and "rpy" in origin.values:
            message = f"{name_of(origin)} has rpy and quat_xyzw; parsers differ in which one they use"
            self.error("duplicate-element", message, attribute.name_span, "remove rpy or quat_xyzw")
        elif attribute is not None and (quaternion := numbers(origin, "quat_xyzw", 4, PLAIN, self)) is not None:
            if not any(quaternion):
                message = f"quat_xyzw of {name_of(origin)} is zero: no rotation"
                self.error("zero-quaternion", message, attribute.span, 'write a rotation, such as "0 0 0 1" for none')
                return
            x, y, z, w = quaternion
            made = Seq(attribute.span)
            for angle in Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rpy():
                made.put(angle + 0.0, attribute.span)
            entry.put("rpy", made, attribute.name_span, attribute.span)
            message = f"quat_xyzw of {name_of(origin)} became rpy: the same rotation"
            self.note("import-converted", message, attribute.span)

    def _joint(self, element: Element, path: TreePath) -> Map:
        entry = Map(element.span)
        kind = self._put_text(entry, "type", element, "type") or ""
        if kind.strip() and kind not in TYPES:
            message = f'{name_of(element)} is of type "{kind}", which URDF does not have'
            self.error("joint-type", message, element.attributes["type"].span, Suggestion(kind, TYPES))
            entry.pop("type")
        kind = kind if kind in TYPES else ""
        self.joint_types.add(kind)
        for end in ("parent", "child"):
            if (inner := self.single(element, end)) is not None:
                self.check_element(inner, None, (*path, end))
                self._put_text(entry, end, inner, "link")
            else:
                help = f'add <{end} link="..."/>'
                self.error("missing-element", f"{name_of(element)} has no <{end}>", element.span, help)
        self._origin(entry, element, path)
        for tag in JOINT_PARTS:
            part = self.single(element, tag)
            if part is not None and tag not in _WITHOUT_EFFECT.get(kind, ()):
                self.check_element(part, None, (*path, tag))
                self._joint_part(part, entry, TYPES[kind] if kind in _WITH_RANGE else PLAIN)
            elif part is not None and tag != "axis":
                self.ignore(f"<{tag}> of a {kind} joint has no effect", part.span)
        if kind in _WITH_RANGE and all(child.tag != "limit" for child in element.children):
            help = 'add <limit lower="" upper="" effort="" velocity=""/>'
            help += ", or make it continuous" if kind == "revolute" else ""
            message = f"{name_of(element)} is {kind} and has no <limit>"
            self.lenient("limit-missing", message, element.span, help, "accepts it without")
        return entry

    def _joint_part(self, element: Element, joint: Map, position: str) -> None:
        tag, entry = element.tag, Map(element.span)
        if tag == "axis":
            self.need(element, "xyz")
            self.put_numbers(joint, element, keys={"xyz": "axis"})
            if "axis" in joint:
                joint.key_spans["axis"] = element.span
            return
        leader = element.get("joint")
        if tag == "mimic" and leader and leader not in self.joints and self.options.lenient:
            self.cannot_carry(name_of(element), element.span, "the joint that it follows does not exist")
            return
        if tag == "mimic" and self._put_text(entry, "joint", element, "joint") is None:
            return
        for name in ("lower", "upper") if position and tag == "limit" else ():
            if name not in element.values:
                put_value(entry, name, 0, element)  # the default in URDF parsers
        self.put_numbers(entry, element, position)
        missing = [name for name in ("effort", "velocity") if tag == "limit" and name not in element.values]
        if missing:
            help = "add them: effort is the largest torque or force, velocity the largest speed"
            self.lenient("limit-incomplete", lacks(element, missing), element.span, help, "accepts it")
        elif tag == "dynamics" and not NUMBERS["dynamics"].keys() & element.values.keys():
            message = f"{name_of(element)} has neither damping nor friction"
            help = "add one, or remove the element: urdfdom, the URDF parser of ROS, rejects the joint"
            self.lenient("missing-attribute", message, element.span, help, "leaves it out")
            return
        elif tag == "calibration" and not entry:
            self.ignore("<calibration> without a value has no effect", element.span)
            return
        elif tag == "safety_controller":
            self.need(element, "k_velocity")
        put_value(joint, tag, entry, element)

    def _materials(self, robot: Element, tree: Map) -> None:
        for element in robot.children:
            name = self._material_name(element) if element.tag == "material" else None
            if name == "":
                self.cannot_carry("a material of the robot without a name", element.span)
            if not name:
                continue
            tree.setdefault_at("materials", Map(element.span), element.span)
            made, entry = tree["materials"], Map(element.span)
            self._look(entry, element)
            if name not in made:
                self.paths[id(element)] = ("materials", name)
                made.put(name, entry, element.attributes["name"].span, element.span)
            elif self.options.lenient:
                self.cannot_carry(f'a second material "{name}"', element.span, "only the first is used")
            else:
                related, help = [Related("the first", made.value_spans[name])], "remove one; --lenient uses the first"
                self.error("duplicate-name", f'the material "{name}" is defined twice', element.span, help, related)

    def _material_name(self, element: Element) -> str | None:
        name = self.attribute(element, "name")
        clean = None if name is None else " ".join(_NOT_IN_MATERIALS.sub("_", name).split())
        if clean != name:
            message = f'the material "{name}" is called "{clean}": a name has no markup and no spaces around it'
            self.note("import-changed", message, element.attributes["name"].span)
        return clean

    def _look(self, entry: Map, element: Element) -> None:
        color, texture = self.single(element, "color"), self.single(element, "texture")
        if color is not None:
            before = len(self.diagnostics)
            self.check_element(color, None, (), "rgba")
            self.put_numbers(entry, color)
            self.spoilt(color, "the colour", before)
        if texture is not None:
            self.check_element(texture)
            if texture.get("filename"):
                self._put_text(entry, "texture", texture, "filename")
            else:  # exporters write an empty <texture/>
                self.ignore("a texture without a file name has no effect", texture.span)
        self.check_element(element)

    def _rename_materials(self, tree: Map) -> None:
        """Remove material names from visuals that look different: urdfdom would use the first material for all."""

        def look(entry: Map) -> tuple[object, object] | None:
            rgba, texture = entry.get("rgba"), entry.get("texture")
            return None if rgba is None and texture is None else (rgba and tuple(map(float, rgba)), texture)

        looks = {name: found for name, one in (tree.get("materials") or {}).items() if (found := look(one))}
        others: list[tuple[str, Span]] = []
        for name, link in (tree.get("links") or {}).items():
            for visual in link.get("visual", ()):
                found, material = look(visual), visual.get("material")
                if material is not None and found and looks.setdefault(material, found) != found:
                    others.append((f'the material "{material}" of link "{name}"', visual.value_spans["material"]))
                    del visual["material"]
        if others:
            more = f",{and_more(len(others) - 1)}" if len(others) > 1 else ""
            message = f"{others[0][0]} differs from an earlier one, which ROS would use for both: its name is removed"
            self.note("import-changed", f"{message}{more}", others[0][1])
