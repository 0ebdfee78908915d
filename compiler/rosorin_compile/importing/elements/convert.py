"""Replace Gazebo and ros2_control elements of a URDF or SDF with equivalent sections of the description.

Each new entry is compiled to XML again and compared with the original element. An element is kept as XML, with a reason
in the report, if its entry violates a rule, if the XML differs, or if the description language cannot express it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple
from xml.etree import ElementTree

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.gazebo import SPRING, element_differences, followers_of
from rosorin_compile.formats.imported_robot import Comment, ImportedRobot, as_tree
from rosorin_compile.formats.robot_files import violations
from rosorin_compile.language.expand.parts import apply_types
from rosorin_compile.language.expand.scope import Expansion, Scope
from rosorin_compile.language.lower import lower
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import ERROR, Source, first_of, has_errors
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.tree import Map, Path, Seq, Text
from rosorin_compile.source.xml.elements import attribute_value, indent_lines, tree_of
from rosorin_compile.source.xml.markup import COMMENT, Remark, parse

from .sections import CannotConvert, GazeboSensor, block, entry, gazebo_of, overlay, read_sensor, without_collisions

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element as Tree

CONTROL, SENSORS, JOINTS, ELEMENTS = "control", "sensors", "joints", "urdf_elements"
_FORMATS = ("urdf", "sdf")
_FEW = 3  # maximum number of names in a line of the report


class Candidate(NamedTuple):
    """An XML element that may be converted to an entry of ``control`` or ``sensors``, or the spring of a joint."""

    section: str
    name: str
    text: int  # index of the XML string in ``urdf_elements``
    number: int  # index among the children of the <gazebo> in that XML string
    element: Tree
    reference: str = ""  # attribute "reference" of the enclosing <gazebo>: a link or joint

    @property
    def message_name(self) -> str:
        """The name of the element in messages, such as ``sensor "lidar"``."""
        return f'{"sensor" if self.section == SENSORS else "<ros2_control>"} "{self.name}"'


class ConvertedRobot(NamedTuple):
    """A robot whose Gazebo and ros2_control elements were converted to sections where possible."""

    imported: ImportedRobot
    plain: Map | None = None  # the robot before the conversion, or None if no element was converted
    names: Mapping[str, Sequence[str]] = {}  # names of the new entries, by kind such as "sensor"
    unsimulated: Sequence[str] = ()  # lidars whose rays MuJoCo does not get
    kept: Mapping[str, str] = {}  # name as in ``Candidate.called`` -> reason why the element stays XML


def with_sections(imported: ImportedRobot) -> ConvertedRobot:
    """Convert Gazebo and ros2_control elements of a robot to entries of ``sensors`` and ``control`` where possible."""
    tree = imported.tree
    texts = tree.get(ELEMENTS) if tree is not None else None
    if tree is None or imported.format not in _FORMATS or not isinstance(texts, Seq):
        return ConvertedRobot(imported)
    robot = imported.robot
    found = [*_candidates(texts), *(_springs(texts, robot) if robot is not None else ())]
    if robot is None or not found:
        return ConvertedRobot(imported)
    return _Conversion(imported, tree, texts, robot).convert(found)


class _Conversion:
    """Converts the XML elements of a robot to sections; ``kept`` has the reason for each element that stays XML."""

    def __init__(self, imported: ImportedRobot, tree: Map, texts: Seq, robot: Robot) -> None:
        self.imported, self.tree, self.texts, self.robot = imported, tree, texts, robot
        self.kept: dict[str, str] = {}

    def convert(self, found: list[Candidate]) -> ConvertedRobot:
        springs = [one for one in found if one.section == JOINTS]
        found = [one for one in found if one.section != JOINTS]
        count = Counter((one.section, one.name) for one in found)
        unique: dict[str, dict[str, Candidate]] = {CONTROL: {}, SENSORS: {}}
        for one in found:
            if one.name and count[one.section, one.name] == 1:
                unique[one.section][one.name] = one
            else:
                self.kept[one.message_name] = "two have this name" if one.name else "it has no name"
        control, distribution = self.control(unique[CONTROL])
        sensors, gazebo = self.sensors(unique[SENSORS])
        taken = [unique[section][name] for section, some in ((CONTROL, control), (SENSORS, sensors)) for name in some]
        taken += springs
        if not taken:
            return ConvertedRobot(self.imported, None, kept=self.kept)
        elements, comments = self.without(taken)
        options = ({"control": distribution} if control else {}) | ({"gazebo": gazebo} if sensors or springs else {})
        outputs: dict[str, Any] = {**(self.tree.get("outputs") or {}), "urdf": options}
        if self.imported.format == "sdf" and sensors:
            outputs["sdf"] = {**(outputs.get("sdf") or {}), "gazebo": gazebo}
        sections = {CONTROL: control, SENSORS: sensors, ELEMENTS: elements, "outputs": outputs}
        imported = self.imported._replace(tree=put_values(self.tree, sections), comments=comments)
        names = {"hardware block": list(control), "sensor": list(sensors)}
        names["spring"] = list(dict.fromkeys(one.name for one in springs))
        names = {key: value for key, value in names.items() if value}
        unsimulated = [name for name, one in sensors.items() if one.get("mjcf") == []]
        return ConvertedRobot(imported, self.tree, names, unsimulated, self.kept)

    def control(self, found: Mapping[str, Candidate]) -> tuple[dict[str, Any], str]:
        """Convert <ros2_control> blocks; return (entries by name, ROS distribution that supports most of them)."""
        made = []
        for distribution in ("jazzy", "humble"):
            humble, options = distribution == "humble", {"control": distribution}
            entries = {name: block(one.element, self.robot, humble) for name, one in found.items()}
            reasons = self.remove_refused(entries, CONTROL, options)
            reasons |= self.remove_different(found, entries, CONTROL, options, followers_of(self.robot, humble))
            made.append((entries, distribution, reasons))
        entries, distribution, reasons = max(made, key=lambda one: len(one[0]))
        self.kept |= {found[name].message_name: reason for name, reason in reasons.items()}
        return entries, distribution

    def sensors(self, found: Mapping[str, Candidate]) -> tuple[dict[str, Any], str]:
        """Convert <sensor> elements; return (entries by name, Gazebo version that most elements are written for)."""
        gazebo = gazebo_of([one.element for one in found.values()])
        sensors: dict[str, GazeboSensor] = {}
        entries: dict[str, Any] = {}
        reasons: dict[str, str] = {}
        for name, one in found.items():
            try:
                sensors[name] = read_sensor(one.element, one.reference)
                entries[name] = entry(sensors[name], self.robot, gazebo)
            except CannotConvert as problem:
                reasons[name] = str(problem)
        options = {"gazebo": gazebo}
        reasons |= self.remove_refused(entries, SENSORS, options)
        robot = self.with_entries(SENSORS, entries, {})[0] if entries else None
        for made in robot.sensors if robot is not None else ():
            if made.name in entries and (changes := overlay(sensors[made.name], made, gazebo)):
                entries[made.name]["gazebo"] = changes
        reasons |= self.remove_refused(entries, SENSORS, options)
        reasons |= self.remove_different(found, entries, SENSORS, options)
        self.kept |= {found[name].message_name: reason for name, reason in reasons.items()}
        return entries, gazebo

    def remove_refused(self, entries: dict[str, Any], section: str, options: Mapping[str, Any]) -> dict[str, str]:
        """Remove entries that cause compile errors; return the first error message for each removed entry."""
        reasons: dict[str, str] = {}
        if entries and self.with_entries(section, entries, options)[1]:
            for name in list(entries):
                if reason := self.with_entries(section, {name: entries[name]}, options)[1]:
                    reasons[name] = reason
                    del entries[name]
            if entries and (together := self.with_entries(section, entries, options)[1]):
                reasons |= dict.fromkeys(entries, together)
                entries.clear()
        return reasons

    def remove_different(
        self,
        found: Mapping[str, Candidate],
        entries: dict[str, Any],
        section: str,
        options: Mapping[str, Any],
        followers: Set[str] = frozenset(),
    ) -> dict[str, str]:
        """Remove entries whose compiled XML differs from the original element; return each first difference."""
        reasons: dict[str, str] = {}
        while entries:  # removing an entry may change the XML of the remaining entries, so compare again
            texts, wrong = self.write(section, entries, options), dict[str, str]()
            for name in entries:
                one = found[name]
                before = ElementTree.tostring(one.element, "unicode")
                if section == SENSORS:
                    reference = f" reference={attribute_value(one.reference)}" if one.reference else ""
                    before = f"<gazebo{reference}>{before}</gazebo>"
                before, *after = without_collisions([before, *texts.get(one.message_name, [])])
                if changes := element_differences([before], after, followers):
                    missing = "nothing is written: its link has no mass that Gazebo keeps it for"
                    wrong[name] = f"written back, it differs: {changes[0]}" if after else missing
            if not wrong:
                break
            reasons |= wrong
            for name in wrong:
                del entries[name]
        return reasons

    def with_entries(self, section: str, entries: Any, options: Mapping[str, Any]) -> tuple[Robot | None, str]:
        """Compile the robot with ``entries`` in a section; return (robot, "") or (None, first error message)."""
        output = {"file": "robot.urdf", **options}
        tree, expansion = put_values(self.tree, {section: entries, "outputs": {"urdf": output}}).copy(), Expansion()
        if isinstance(tree.get(SENSORS), Map):
            tree[SENSORS] = tree[SENSORS].copy()
            apply_types(tree, None, Scope(expansion), data_folder("parts_library") / "sensors.yaml")
        found = [*expansion.diagnostics, *validate(tree, FORMATS)]
        found = found if has_errors(found) else violations(tree)
        message = next((one.message for one in found if one.severity == ERROR), "")
        return (None if message else lower(tree).robot), message

    def write(self, section: str, entries: dict[str, Any], options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Compile entries of a section to URDF elements; return a list of XML strings for each ``Candidate.called``."""
        robot, brings = self.with_entries(section, entries, options)[0], FORMATS["urdf"].brings
        found: dict[str, list[str]] = {}
        if robot is not None and brings is not None:
            for text in brings(robot, Output("urdf", "urdf", "robot.urdf", {**options, "number_format": "exact"})):
                for one in _candidates([text]):
                    found.setdefault(one.message_name, []).append(text)
        return found

    def without(self, taken: list[Candidate]) -> tuple[Seq, list[Comment]]:
        """Remove the elements ``taken`` from the XML; return the remaining XML, and all comments with new paths."""
        left, paths, inner = Seq(self.texts.span, self.texts.via), dict[int, Path](), list[Comment]()
        for index, (text, span) in enumerate(zip(self.texts, self.texts.value_spans, strict=True)):
            rest = str(text)
            if mine := [one for one in taken if one.text == index]:
                rest, remarks = _cut(rest, mine)
                inner += [Comment(words, span, path) for path, words in remarks]
            paths[index] = (ELEMENTS, len(left)) if rest else (mine[0].section, mine[0].name)
            if rest:
                left.put(Text(rest), span)
        comments = []
        for comment in self.imported.comments:
            section, *place = comment.path[:2] or ("",)
            moved = paths.get(int(place[0])) if section == ELEMENTS and place else None
            comments.append(comment if moved is None else comment._replace(path=moved))
        return left, [*comments, *inner]


def _candidates(texts: Sequence[str]) -> list[Candidate]:
    """Find the <ros2_control> and <sensor> elements in strings of XML; skip strings that are not XML."""
    found = []
    for index, text in enumerate(texts):
        with suppress(ValueError):
            for element in tree_of(f"<all>{text}</all>"):
                if element.tag == "ros2_control":
                    found.append(Candidate(CONTROL, element.get("name", "").strip(), index, 0, element))
                elif element.tag == "gazebo" and set(element.attrib) <= {"reference"}:
                    reference = element.get("reference", "").strip()
                    for number, child in ((i, child) for i, child in enumerate(element) if child.tag == "sensor"):
                        found.append(Candidate(SENSORS, child.get("name", "").strip(), index, number, child, reference))
    return found


def _springs(texts: Sequence[str], robot: Robot) -> list[Candidate]:
    """Find the springs that the import also read as ``dynamics`` of a joint, and that a URDF for Gazebo has again."""
    found = list[Candidate]()
    for index, text in enumerate(texts):
        with suppress(ValueError):
            for element in tree_of(f"<all>{text}</all>"):
                joint = robot.joint.get(element.get("reference", "")) if element.tag == "gazebo" else None
                if joint is not None and joint.moves and joint.dynamics is not None and joint.dynamics.stiffness:
                    springs = [(i, one) for i, one in enumerate(element) if one.tag in SPRING and not one.attrib]
                    found += [Candidate(JOINTS, joint.name, index, number, one) for number, one in springs]
    count = Counter((one.name, one.element.tag) for one in found)
    twice = {name for (name, _), number in count.items() if number > 1}
    return [one for one in found if one.name not in twice]


def _cut(text: str, taken: list[Candidate]) -> tuple[str, list[tuple[Path, str]]]:
    """Remove elements from an XML string; return (remaining XML, [(entry path, comment inside a removed element)])."""
    root = parse(Source("", f"<all>{text}</all>")).root
    outer = root.children[0]
    elements = [(one.name, outer if one.section == CONTROL else outer.children[one.number]) for one in taken]
    is_empty = outer.tag != "gazebo" or len(outer.children) == len(taken)
    remarks: dict[int, tuple[Path, str]] = {}  # (entry path, comment) by offset in ``text``
    for name, element in (*elements, *([(taken[0].name, outer)] if is_empty else [])):
        for item in (item for inner in element.iter() for item in inner.content):
            if isinstance(item, Remark) and item.kind == COMMENT:
                remarks.setdefault(item.start, ((taken[0].section, name), item.text))
    comments = [remarks[start] for start in sorted(remarks)]
    if is_empty:
        return "", comments
    rest = root.document.source.text[outer.start : outer.end]
    for _, element in sorted(elements, key=lambda one: one[1].start, reverse=True):
        start, end = element.start - outer.start, element.end - outer.start
        rest = rest[:start].rstrip(" \t") + rest[end:].lstrip(" \t")
    return indent_lines("\n".join(line for line in rest.split("\n") if line.strip()), ""), comments


def put_values(tree: Map, values: Mapping[str, Any]) -> Map:
    """Return a copy of a description with the top-level keys in ``values`` replaced; an empty value removes the key."""
    made = tree.copy()
    for key, value in values.items():
        if value:
            plain = value if isinstance(value, (Map, Seq)) else as_tree(value, tree.span, [key])
            made.put(key, plain, tree.span, tree.span)
        else:
            made.pop(key, None)
    return made


def report_elements(converted: ConvertedRobot) -> list[str]:
    """Return the lines of the import report about converted elements and elements that stay XML."""
    lines = []
    if converted.names:
        parts = [
            f"{len(names)} {word}{'' if len(names) == 1 else 's'} ({first_of(list(names), _FEW)})"
            for word, names in converted.names.items()
        ]
        lines.append(f"converted, and equal when they are written back: {', '.join(parts)}")
    if converted.unsimulated:
        what = f"{first_of(list(converted.unsimulated), _FEW)}: too many rays, or a field of view that is not symmetric"
        lines.append(f'left out of the MJCF: {what}; replace "mjcf: []" in the sensor')
    reasons: dict[str, list[str]] = {}
    for what, why in converted.kept.items():
        reasons.setdefault(why, []).append(what)
    return [*lines, *(f"kept as XML: {first_of(names, _FEW)}: {why}" for why, names in reasons.items())]
