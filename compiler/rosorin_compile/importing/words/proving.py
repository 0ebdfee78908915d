"""Replace elements of a URDF by sections of the language where both mean the same.

Each entry is written as an element again and compared with the element that it came from. What a rule refuses, what
comes out differently and what the language cannot express is kept as it was, with the reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.gazebo_elements import element_differences, followers_of
from rosorin_compile.formats.imported import Imported
from rosorin_compile.formats.reading import violations
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expand.expansion import Expansion
from rosorin_compile.language.expand.parts import apply_types
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.lower import lower
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot, Sensor
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, and_more, first_of, has_errors
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.elements import tree_of

from .blocks import Unsayable, block
from .drives import Driven, driven
from .sensors import Seen, entry, gazebo_of, overlay, seen, without_collisions
from .taking import CONTROL, SENSORS, Candidate, candidates, moved, put, trees, without

_FORMATS = ("urdf", "sdf")
_UNROUNDED = {"number_format": "exact"}
_FEW, _MOST = 3, 12  # names, and lines, of a report
_MANY = 40  # so many are tried one by one, when a rule refuses them together


class Worded(NamedTuple):
    """A robot whose elements became sections: ``said`` are the new entries by kind, ``kept`` reasons by element.

    ``remarks`` are differences between a plug-in and the robot. ``plain`` is the tree with all elements.
    """

    imported: Imported
    plain: Map | None = None
    said: Mapping[str, Sequence[str]] = {}
    kept: Mapping[str, str] = {}
    remarks: Sequence[str] = ()


def _with_types(tree: Map) -> tuple[Map, list[Diagnostic]]:
    """Return a tree with the defaults of the types of its sensors, and diagnostics about these."""
    made, expansion = tree.copied(), Expansion()
    if isinstance(made.get(SENSORS), Map):
        made[SENSORS] = made[SENSORS].copied()
        apply_types(made, None, Scope(expansion), data_folder("parts_library") / "sensors.yaml")
    return made, expansion.diagnostics


def worded(imported: Imported) -> Worded:
    """Return a robot with sections instead of the elements of its URDF or SDF, as far as possible."""
    tree = imported.tree
    texts = tree.get("urdf_elements") if tree is not None else None
    if tree is None or imported.format not in _FORMATS or not isinstance(texts, Seq):
        return Worded(imported)
    found, robot = candidates(texts), imported.robot
    if robot is None or not (found or any("<plugin" in text for text in texts)):
        return Worded(imported)
    return _Conversion(imported, tree, texts, robot).worded(found)


class _Conversion:
    """The conversion of one robot; ``kept`` are the reasons why elements are kept."""

    def __init__(self, imported: Imported, tree: Map, texts: Seq, robot: Robot) -> None:
        self.imported, self.tree, self.texts, self.robot = imported, tree, texts, robot
        self.kept: dict[str, str] = {}
        self.known_errors = {one.message for one in self.errors({})}

    def worded(self, found: list[Candidate]) -> Worded:
        """Return the robot with sections."""
        count = Counter((one.section, one.name) for one in found)
        for one in found:
            if not one.name or count[one.section, one.name] > 1:
                self.kept[one.called] = "two have this name" if one.name else "it has no name"
        found = [one for one in found if one.name and count[one.section, one.name] == 1]
        control, distribution = self.control([one for one in found if one.section == CONTROL])
        sensors, asked = self.sensors([one for one in found if one.section == SENSORS])
        taken = [one for one in found if one.name in (control if one.section == CONTROL else sensors)]
        options = ({"control": distribution} if control else {}) | ({"gazebo": asked} if sensors else {})
        drive = self.driven(driven(trees(self.texts), self.robot))
        self.kept |= _never_written(self.texts)
        if not taken and not drive.sections:
            return Worded(self.imported, None, {}, self.kept, drive.remarks)
        rest = without(self.texts, taken)
        sections = {CONTROL: control, SENSORS: sensors, **drive.sections, "urdf_elements": rest.texts}
        if options:
            outputs: dict[str, Any] = {**(self.tree.get("outputs") or {}), "urdf": dict(options)}
            if self.imported.format == "sdf" and "gazebo" in options:
                outputs["sdf"] = {**(outputs.get("sdf") or {}), "gazebo": asked}
            sections["outputs"] = outputs
        comments = [*moved(self.imported.comments, rest.paths), *rest.comments]
        imported = self.imported._replace(tree=put(self.tree, sections), comments=comments)
        names = {"hardware block": list(control), "sensor": list(sensors), **drive.said}
        said = {key: value for key, value in names.items() if value}
        return Worded(imported, self.tree, said, self.kept, drive.remarks)

    def control(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of hardware blocks that mean the same, and the distribution that most of them are for."""
        best: tuple[dict[str, Any], str, dict[str, str]] = ({}, "jazzy", {})
        for distribution in ("jazzy", "humble") if found else ():
            humble, entries, reasons = distribution == "humble", dict[str, Any](), dict[str, str]()
            for one in found:
                try:
                    entries[one.name] = block(one.element, self.robot, humble)
                except Unsayable as problem:
                    reasons[one.called] = f"there is no word for it: {problem}"
            options = {"control": distribution}
            reasons |= self._refused(found, entries, CONTROL, options)
            written = self._written({CONTROL: entries}, options) if entries else {}
            for one in [one for one in found if one.name in entries]:
                reason = _difference(one, written.get(one.called, []), followers_of(self.robot, humble))
                if reason:
                    del entries[one.name]
                    reasons[one.called] = reason
            if len(entries) > len(best[0]) or distribution == "jazzy":
                best = entries, distribution, reasons
        self.kept |= best[2]
        return best[0], best[1]

    def sensors(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of sensors that mean the same, and the Gazebo that most of them are for."""
        parsed: dict[str, Seen] = {}
        entries: dict[str, Any] = {}
        for one in found:
            try:
                parsed[one.name] = seen(one.element, one.reference)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        asked = gazebo_of(list(parsed.values())) if parsed else ""
        for one in [one for one in found if one.name in parsed]:
            try:
                entries[one.name] = entry(parsed[one.name], self.robot, asked)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        typed = self._typed(entries)
        for one in [one for one in found if one.name in entries]:
            if one.name not in typed:
                del entries[one.name]
                self.kept[one.called] = "there is no word for it: its type does not take what it says"
            elif changes := overlay(parsed[one.name], typed[one.name], asked):
                entries[one.name]["gazebo"] = changes
        options = {"gazebo": asked}
        self.kept |= self._refused(found, entries, SENSORS, options)
        while entries:  # what keeps one sensor from being merged changes another one
            written = self._written({SENSORS: entries}, options)
            of_model = self._written_sdf(entries, options) if self.imported.format == "sdf" else None
            wrong = {}
            for one in [one for one in found if one.name in entries]:
                reason = _difference(one, written.get(one.called, []), frozenset())
                if not reason and of_model is not None:
                    reason = _difference(one, of_model.get(one.called, []), frozenset())
                if reason:
                    wrong[one.name] = self.kept[one.called] = reason
            if not wrong:
                break
            for name in wrong:
                del entries[name]
        return entries, asked

    def _typed(self, entries: dict[str, Any]) -> dict[str, Sensor]:
        """Return the sensors whose type has one in Gazebo; if there is an error, entries are tried one by one."""

        def of(some: dict[str, Any]) -> dict[str, Sensor]:
            frames = put(Map(self.tree.span, self.tree.via), {"robot": self.tree["robot"], "links": links})
            if "joints" in self.tree:
                frames.put("joints", self.tree["joints"], self.tree.span, self.tree.span)
            tree, diagnostics = _with_types(put(frames, {SENSORS: some}))
            robot = None if diagnostics else lower(tree).robot
            return {one.name: one for one in robot.sensors if len(one.gazebo) == 1} if robot else {}

        links: dict[str, Any] = {name: {} for name in self.tree.get("links") or ()}
        found = of(entries) if entries else {}
        return found or {name: one for key, value in entries.items() for name, one in of({key: value}).items()}

    def driven(self, wanted: Driven) -> Driven:
        """Return what plug-ins specify about the drive and transforms, as far as no rule refuses it."""
        sections, said = dict(wanted.sections), dict(wanted.said)
        for word, keys in (("drive", ("drive",)), ("transform", ("publishers", "edges"))):
            some = {key: sections[key] for key in keys if key in sections}
            reason = self._new_error(some) if some else ""
            if reason:
                sections = {key: value for key, value in sections.items() if key not in some}
                self.kept[f"the {word} of {', '.join(said.pop(word, ['a plug-in']))}"] = reason
        self.kept |= wanted.kept
        return wanted._replace(sections=sections, said=said)

    def _refused(
        self, found: list[Candidate], entries: dict[str, Any], section: str, options: Mapping[str, Any]
    ) -> dict[str, str]:
        """Remove the entries that a rule refuses, and return the reasons."""
        reasons: dict[str, str] = {}
        if not entries or not self._new_error({section: entries}, options):
            return reasons
        for one in [one for one in found if one.name in entries]:
            alone = {section: {one.name: entries[one.name]}}
            reason = self._new_error(alone, options) if len(entries) <= _MANY else "a rule refuses one of many"
            if reason:
                reasons[one.called] = reason
        for one in found:
            if one.called in reasons:
                entries.pop(one.name, None)
        together = self._new_error({section: entries}, options) if entries else ""
        if together:
            reasons |= {one.called: together for one in found if one.name in entries}
            entries.clear()
        return reasons

    def _new_error(self, sections: dict[str, Any], options: Mapping[str, Any] | None = None) -> str:
        """Return the first error that the robot has only with these sections, or ""."""
        found = self.errors(sections, options)
        return next((one.message for one in found if one.message not in self.known_errors), "")

    def errors(self, sections: dict[str, Any], options: Mapping[str, Any] | None = None) -> list[Diagnostic]:
        """Return the errors of the robot with more sections."""
        output = {"file": "robot.urdf", **(options or {})}
        tree, diagnostics = _with_types(put(self.tree, {**sections, "outputs": {"urdf": output}}))
        found = [one for one in validate(tree, FORMATS) if one.severity == ERROR]
        if not found and not diagnostics:
            found = [one for one in violations(tree) if one.severity == ERROR]
        return [*diagnostics, *found]

    def _robot(self, sections: dict[str, Any]) -> Robot | None:
        tree, diagnostics = _with_types(put(self.tree, sections))
        return None if diagnostics or has_errors(validate(tree, FORMATS)) else lower(tree).robot

    def _written(self, sections: dict[str, Any], options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return the elements of the URDF that the robot becomes: those of hardware blocks and sensors."""
        robot, brings = self._robot(sections), FORMATS["urdf"].brings
        found: dict[str, list[str]] = {}
        if robot is not None and brings is not None:
            for text in brings(robot, Output("urdf", "urdf", "robot.urdf", {**options, **_UNROUNDED})):
                texts = Seq(self.texts.span)
                texts.put(text, self.texts.span)
                for one in candidates(texts):
                    found.setdefault(one.called, []).append(text)
        return found

    def _written_sdf(self, entries: dict[str, Any], options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return the sensors of the SDF that the robot becomes, as if each was in a <gazebo> of its link."""
        robot = self._robot({SENSORS: entries, "urdf_elements": ()})
        found: dict[str, list[str]] = {}
        if robot is not None:
            output = Output("sdf", "sdf", "robot.sdf", {**options, **_UNROUNDED})
            text, _ = FORMATS["sdf"].written(robot, output, Templates())
            for place in (place for place in tree_of(text).iter() if place.tag in ("link", "joint")):
                for sensor in (child for child in place if child.tag == "sensor"):
                    pose = sensor.find("pose")
                    frame = "" if pose is None else pose.attrib.pop("relative_to", "")
                    if pose is not None and not pose.text:
                        sensor.remove(pose)
                    one = Candidate(SENSORS, sensor.get("name", ""), 0, 0, sensor, frame or place.get("name", ""))
                    found.setdefault(one.called, []).append(one.alone)
        return found


def _never_written(texts: Seq) -> dict[str, str]:
    """Return the elements that no output writes, with the reason."""
    found: dict[str, str] = {}
    for _, element in trees(texts):
        if element.tag == "transmission":
            found[f'<transmission> "{element.get("name", "")}"'] = "it is of ROS 1: ros2_control has its own"
        for plugin in element if element.tag == "gazebo" else ():
            if plugin.tag == "plugin":
                found[f'plug-in "{plugin.get("name", "")}"'] = "no output writes plug-ins"
    return found


def _difference(one: Candidate, texts: Sequence[str], followers: frozenset[str]) -> str:
    """Return why an element that is written again differs from its source, or ""."""
    alone, *written = without_collisions([one.alone, *texts])
    wrong = element_differences([alone], written, followers)
    if not wrong:
        return ""
    if not texts:
        return "it would not be written again: its link has no mass that Gazebo keeps it for"
    new = [text for text in wrong if text.endswith("is new")]
    more = [text for text in new if "<sensor" not in text and "<ros2_control" not in text]
    return "written again it would not say the same" + (f": {more[0]}" if more else "")


def told_words(worded: Worded) -> list[str]:
    """Return the lines about the elements that became sections, and about those that did not."""
    lines = []
    if worded.said:
        parts = [
            f"{len(names)} {word}{'' if len(names) == 1 else 's'} ({first_of(list(names), _FEW)})"
            for word, names in worded.said.items()
        ]
        lines.append("in words, and the same when they are written again: " + ", ".join(parts))
    reasons: dict[str, list[str]] = {}
    for what, why in worded.kept.items():
        reasons.setdefault(why, []).append(what)
    told = [f"not in words: {first_of(names, _FEW)}: {why}" for why, names in reasons.items()]
    if len(told) > _MOST:
        told[_MOST:] = [f"not in words:{and_more(len(told) - _MOST)}"]
    return [*lines, *told, *worded.remarks]
