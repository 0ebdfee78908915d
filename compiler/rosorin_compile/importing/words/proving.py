"""Replace elements of a URDF or SDF by sections of the language where both mean the same.

Each entry is written as an element again and compared with the element that it came from. What a rule refuses, what
comes out differently and what the language cannot express is kept as it was, with the reason.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence, Set
from typing import Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.gazebo import element_differences, followers_of
from rosorin_compile.formats.imported_robot import Imported
from rosorin_compile.formats.robot_files import violations
from rosorin_compile.language.expand.expansion import Expansion
from rosorin_compile.language.expand.parts import apply_types
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.lower import lower
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import ERROR, and_more, first_of, has_errors
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.tree import Map, Seq

from .blocks import block
from .drives import Driven, read_drives
from .sensors import Seen, Unsayable, entry, gazebo_of, overlay, read_sensor, without_collisions
from .taking import CONTROL, SENSORS, Candidate, candidates, move_comments, put, trees, without

_FORMATS = ("urdf", "sdf")
_UNROUNDED = {"number_format": "exact"}
_FEW, _MOST = 3, 12  # names, and lines, of a report


class Worded(NamedTuple):
    """A robot whose elements became sections: ``said`` are the new entries by kind, ``kept`` reasons by element.

    ``plain`` is the tree with all elements.
    """

    imported: Imported
    plain: Map | None = None
    said: Mapping[str, Sequence[str]] = {}
    kept: Mapping[str, str] = {}


def with_sections(imported: Imported) -> Worded:
    """Return a robot with sections instead of the elements of its URDF or SDF, as far as possible."""
    tree = imported.tree
    texts = tree.get("urdf_elements") if tree is not None else None
    if tree is None or imported.format not in _FORMATS or not isinstance(texts, Seq):
        return Worded(imported)
    found, robot = candidates(texts), imported.robot
    if robot is None or not (found or any("<plugin" in text for text in texts)):
        return Worded(imported)
    return _Conversion(imported, tree, texts, robot).convert(found)


class _Conversion:
    """The conversion of one robot; ``kept`` are the reasons why elements are kept."""

    def __init__(self, imported: Imported, tree: Map, texts: Seq, robot: Robot) -> None:
        self.imported, self.tree, self.texts, self.robot = imported, tree, texts, robot
        self.kept: dict[str, str] = {}

    def convert(self, found: list[Candidate]) -> Worded:
        """Return the robot with sections."""
        count = Counter((one.section, one.name) for one in found)
        for one in found:
            if not one.name or count[one.section, one.name] > 1:
                self.kept[one.called] = "two have this name" if one.name else "it has no name"
        found = [one for one in found if one.name and count[one.section, one.name] == 1]
        control, distribution = self.control([one for one in found if one.section == CONTROL])
        sensors, gazebo = self.sensors([one for one in found if one.section == SENSORS])
        taken = [one for one in found if one.name in (control if one.section == CONTROL else sensors)]
        drives = self.drives()
        if not taken and not drives.sections:
            return Worded(self.imported, None, {}, self.kept)
        rest = without(self.texts, taken)
        sections = {CONTROL: control, SENSORS: sensors, **drives.sections, "urdf_elements": rest.texts}
        options = ({"control": distribution} if control else {}) | ({"gazebo": gazebo} if sensors else {})
        if options:
            outputs: dict[str, Any] = {**(self.tree.get("outputs") or {}), "urdf": dict(options)}
            if self.imported.format == "sdf" and "gazebo" in options:
                outputs["sdf"] = {**(outputs.get("sdf") or {}), "gazebo": gazebo}
            sections["outputs"] = outputs
        comments = [*move_comments(self.imported.comments, rest.paths), *rest.comments]
        imported = self.imported._replace(tree=put(self.tree, sections), comments=comments)
        names = {"hardware block": list(control), "sensor": list(sensors), **drives.said}
        said = {key: value for key, value in names.items() if value}
        return Worded(imported, self.tree, said, self.kept)

    def control(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of hardware blocks that mean the same, and the distribution that most of them are for."""
        best: tuple[dict[str, Any], str, dict[str, str]] = ({}, "jazzy", {})
        for distribution in ("jazzy", "humble") if found else ():
            humble = distribution == "humble"
            entries = {one.name: block(one.element, self.robot, humble) for one in found}
            followers = followers_of(self.robot, humble)
            reasons = self.reject(found, entries, CONTROL, {"control": distribution}, followers)
            if len(entries) > len(best[0]) or not humble:
                best = entries, distribution, reasons
        self.kept |= best[2]
        return best[0], best[1]

    def sensors(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of sensors that mean the same, and the Gazebo that most of them are for."""
        parsed: dict[str, Seen] = {}
        entries: dict[str, Any] = {}
        for one in found:
            try:
                parsed[one.name] = read_sensor(one.element, one.reference)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        gazebo = gazebo_of(list(parsed.values())) if parsed else ""
        for one in [one for one in found if one.name in parsed]:
            try:
                entries[one.name] = entry(parsed[one.name], self.robot, gazebo)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        self.kept |= self.remove_refused(found, entries, SENSORS, {"gazebo": gazebo})
        robot = self.with_sections({SENSORS: entries})[0] if entries else None
        for sensor in robot.sensors if robot is not None else ():
            if sensor.name in entries and (changes := overlay(parsed[sensor.name], sensor, gazebo)):
                entries[sensor.name]["gazebo"] = changes
        self.kept |= self.reject(found, entries, SENSORS, {"gazebo": gazebo})
        return entries, gazebo

    def drives(self) -> Driven:
        """Return what plug-ins specify about the drive and transforms, as far as no rule refuses it."""
        found = read_drives(trees(self.texts), self.robot)
        for word, keys in (("drive", ("drive",)), ("transform", ("publishers", "edges"))):
            some = {key: found.sections[key] for key in keys if key in found.sections}
            if some and (reason := self.error(some)):
                for key in some:
                    del found.sections[key]
                self.kept[f"the {word} of {', '.join(found.said.pop(word, ['a plug-in']))}"] = reason
        self.kept |= found.kept
        return found

    def reject(
        self,
        found: list[Candidate],
        entries: dict[str, Any],
        section: str,
        options: Mapping[str, Any],
        followers: Set[str] = frozenset(),
    ) -> dict[str, str]:
        """Remove the entries that a rule refuses or that are not written as they were, and return the reasons."""
        reasons = self.remove_refused(found, entries, section, options)
        while entries:  # the reason why one entry comes out differently may be another one
            wrong: dict[str, str] = {}
            texts = self.write(section, entries, options)
            for one in [one for one in found if one.name in entries]:
                if reason := _difference(one, texts.get(one.called, []), followers):
                    wrong[one.name] = reasons[one.called] = reason
            if not wrong:
                break
            for name in wrong:
                del entries[name]
        return reasons

    def remove_refused(
        self, found: list[Candidate], entries: dict[str, Any], section: str, options: Mapping[str, Any]
    ) -> dict[str, str]:
        """Remove the entries that a rule refuses, alone or together, and return the reasons."""
        reasons: dict[str, str] = {}
        if entries and self.error({section: entries}, options):
            for one in [one for one in found if one.name in entries]:
                if reason := self.error({section: {one.name: entries[one.name]}}, options):
                    reasons[one.called] = reason
                    del entries[one.name]
            if together := self.error({section: entries}, options) if entries else "":
                reasons |= {one.called: together for one in found if one.name in entries}
                entries.clear()
        return reasons

    def error(self, sections: dict[str, Any], options: Mapping[str, Any] | None = None) -> str:
        """Return the first error that the robot has with these sections, or ""."""
        return self.with_sections(sections, options)[1]

    def with_sections(
        self, sections: dict[str, Any], options: Mapping[str, Any] | None = None
    ) -> tuple[Robot | None, str]:
        """Return the robot with more sections, or None and its first error."""
        output = {"file": "robot.urdf", **(options or {})}
        tree, expansion = put(self.tree, {**sections, "outputs": {"urdf": output}}).copy(), Expansion()
        if isinstance(tree.get(SENSORS), Map):
            tree[SENSORS] = tree[SENSORS].copy()
            apply_types(tree, None, Scope(expansion), data_folder("parts_library") / "sensors.yaml")
        found = [*expansion.diagnostics, *validate(tree, FORMATS)]
        found = found if has_errors(found) else violations(tree)
        message = next((one.message for one in found if one.severity == ERROR), "")
        return (None if message else lower(tree).robot), message

    def write(self, section: str, entries: dict[str, Any], options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return the elements of the URDF that entries become, by name."""
        robot, brings = self.with_sections({section: entries}, options)[0], FORMATS["urdf"].brings
        found: dict[str, list[str]] = {}
        if robot is not None and brings is not None:
            for text in brings(robot, Output("urdf", "urdf", "robot.urdf", {**options, **_UNROUNDED})):
                texts = Seq(self.texts.span)
                texts.put(text, self.texts.span)
                for one in candidates(texts):
                    found.setdefault(one.called, []).append(text)
        return found


def _difference(one: Candidate, texts: Sequence[str], followers: Set[str]) -> str:
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


def report_words(worded: Worded) -> list[str]:
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
    return [*lines, *told]
