"""Proving: entries that elements may become are written as elements again, and stay where both mean the same.

What a rule refuses, what comes out otherwise and what the language has no word for stays as it was, with the reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.compare.proof import Proof
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.checked import errors
from rosorin_compile.formats.imported import Imported
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot, Sensor
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Document

from .blocks import Unsayable, block
from .drives import Driven, driven
from .sensors import Seen, entry, gazebo_of, overlay, seen, without_collisions
from .taking import CONTROL, SENSORS, Candidate, candidates, moved, put, trees, without

_FORMATS = ("urdf", "sdf")
_UNROUNDED = {"number_format": "exact"}
_MANY = 40  # so many are tried one by one, when a rule refuses them together


class Worded(NamedTuple):
    """A robot with words for elements: ``said`` what became words, ``kept`` what did not and why.

    ``remarks`` is what a plug-in says otherwise than the robot. ``plain`` is the tree without any of it.
    """

    imported: Imported
    plain: Map | None = None
    said: Mapping[str, Sequence[str]] = {}
    kept: Mapping[str, str] = {}
    remarks: Sequence[str] = ()


def worded(imported: Imported) -> Worded:
    """Return a robot that was read from a URDF with what else it says in words, as far as it goes."""
    tree = imported.tree
    texts = tree.get("urdf_elements") if tree is not None else None
    if tree is None or imported.format not in _FORMATS or not isinstance(texts, Seq):
        return Worded(imported)
    found, robot = candidates(texts), imported.robot
    if robot is None or (not found and not _has_plugins(texts)):
        return Worded(imported)
    return _Proving(imported, tree, texts, robot).worded(found)


def _has_plugins(texts: Seq) -> bool:
    return any("<plugin" in text for text in texts)


class _Proving:
    def __init__(self, imported: Imported, tree: Map, texts: Seq, robot: Robot) -> None:
        self.imported = imported
        self.tree = tree
        self.texts = texts
        self.robot = robot
        self.bare = _bare(tree)
        self.kept: dict[str, str] = {}
        self.before = {one.message for one in self.problems(tree, {})}

    def worded(self, found: list[Candidate]) -> Worded:
        """Return the robot in words."""
        found = self._named_once(found)
        control, distribution = self.control([one for one in found if one.section == CONTROL])
        sensors, asked = self.sensors([one for one in found if one.section == SENSORS])
        taken = [one for one in found if one.name in (control if one.section == CONTROL else sensors)]
        options: dict[str, Any] = {"control": distribution} if control else {}
        options |= {"gazebo": asked} if sensors else {}
        drive = self.driven(driven(trees(self.texts), self.robot))
        self.kept |= _unwritten(self.texts)
        if not taken and not drive.sections:
            return Worded(self.imported, None, {}, self.kept, drive.remarks)
        rest = without(self.texts, taken)
        outputs = {"outputs": self._wishes(options)} if options else {}
        sections = {CONTROL: control, SENSORS: sensors, **drive.sections, "urdf_elements": rest.texts, **outputs}
        comments = [*moved(self.imported.comments, rest.paths), *rest.comments]
        made = self.imported._replace(tree=put(self.tree, sections), comments=comments)
        names = {"hardware block": list(control), "sensor": list(sensors), **drive.said}
        return Worded(made, self.tree, {key: value for key, value in names.items() if value}, self.kept, drive.remarks)

    def _wishes(self, options: Mapping[str, Any]) -> dict[str, Any]:
        """Return what the outputs of the source's own have to be asked for, so that words are written."""
        wishes: dict[str, Any] = {**(self.tree.get("outputs") or {}), "urdf": dict(options)}
        if self.imported.format == "sdf" and "gazebo" in options:
            wishes["sdf"] = {**(wishes.get("sdf") or {}), "gazebo": options["gazebo"]}
        return wishes

    def _named_once(self, found: list[Candidate]) -> list[Candidate]:
        """Return the candidates whose name no other one has."""
        count: dict[tuple[str, ...], int] = {}
        for one in found:
            key = (one.section, one.name)
            count[key] = count.get(key, 0) + 1
        for one in found:
            if count[one.section, one.name] > 1 or not one.name:
                self.kept[one.called] = "it has no name" if not one.name else "two have this name"
        return [one for one in found if one.name and count[one.section, one.name] == 1]

    # Hardware blocks

    def control(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of hardware blocks that say the same, and for which distribution."""
        best: tuple[dict[str, Any], str, dict[str, str]] = ({}, "jazzy", {})
        for distribution in ("jazzy", "humble") if found else ():
            made, why = self._control(found, distribution)
            if len(made) > len(best[0]) or distribution == "jazzy":
                best = made, distribution, why
        self.kept |= best[2]
        return best[0], best[1]

    def _control(self, found: list[Candidate], distribution: str) -> tuple[dict[str, Any], dict[str, str]]:
        made: dict[str, Any] = {}
        why: dict[str, str] = {}
        humble = distribution == "humble"
        for one in found:
            try:
                made[one.name] = block(one.element, self.robot, humble)
            except Unsayable as problem:
                why[one.called] = f"there is no word for it: {problem}"
        options = {"control": distribution}
        why |= self._refused(found, made, options, lambda some: {CONTROL: some})
        written = self._written(self._lowered({CONTROL: made}), options) if made else {}
        for one in [one for one in found if one.name in made]:
            texts = written.get(one.called, [])
            wrong = Proof.of([one.alone], texts, Proof.elements(self.robot, humble=humble)).texts
            if wrong:
                del made[one.name]
                why[one.called] = _otherwise(wrong, texts)
        return made, why

    # Sensors

    def sensors(self, found: list[Candidate]) -> tuple[dict[str, Any], str]:
        """Return the entries of sensors that say the same, and for which Gazebo."""
        all_seen: dict[str, Seen] = {}
        for one in found:
            try:
                all_seen[one.name] = seen(one.element, one.reference)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        asked = gazebo_of(list(all_seen.values())) if all_seen else ""
        made: dict[str, Any] = {}
        for one in [one for one in found if one.name in all_seen]:
            try:
                made[one.name] = entry(all_seen[one.name], self.robot, asked)
            except Unsayable as problem:
                self.kept[one.called] = f"there is no word for it: {problem}"
        brought = self._brought(made)
        for one in [one for one in found if one.name in made]:
            if one.name not in brought:
                del made[one.name]
                self.kept[one.called] = "there is no word for it: its type does not take what it says"
                continue
            changes = overlay(all_seen[one.name], brought[one.name], asked)
            if changes:
                made[one.name]["gazebo"] = changes
        options = {"gazebo": asked}
        self.kept |= self._refused(found, made, options, lambda some: {SENSORS: some})
        while made:  # what one sensor keeps from being merged changes what another one has
            written = self._written(self._lowered({SENSORS: made}), options)
            wrong = {one: _differs(one, written.get(one.called, [])) for one in found if one.name in made}
            if self.imported.format == "sdf":
                of_model = self._of_model(made, options)
                wrong = {one: why or _differs(one, of_model.get(one.called, [])) for one, why in wrong.items()}
            if not any(wrong.values()):
                break
            for one in [one for one, why in wrong.items() if why]:
                del made[one.name]
                self.kept[one.called] = wrong[one]
        return made, asked

    def _brought(self, made: dict[str, Any]) -> dict[str, Sensor]:
        """Return the sensors of entries whose type brings one of Gazebo; of a few at once that is told apart."""

        def all_of(some: dict[str, Any]) -> dict[str, Sensor]:
            bare = Imported(self.bare, []).with_sections({SENSORS: some}).typed()
            robot = None if bare.diagnostics else bare.robot
            return {one.name: one for one in robot.sensors if len(one.gazebo) == 1} if robot else {}

        found = all_of(made) if made else {}
        return found or {name: one for key, value in made.items() for name, one in all_of({key: value}).items()}

    # The drive, and who publishes what

    def driven(self, wanted: Driven) -> Driven:
        """Return what plug-ins say of the drive and of transforms, as far as no rule refuses it."""
        sections = dict(wanted.sections)
        told = dict(wanted.said)
        for keys in (("drive",), ("publishers", "edges")):
            mine = {key: sections[key] for key in keys if key in sections}
            problems = self.problems(self.tree, mine) if mine else []
            new = next((one.message for one in problems if one.message not in self.before), "")
            if new:
                for key in mine:
                    del sections[key]
                word = "drive" if keys[0] == "drive" else "transform"
                self.kept[f"the {word} of {', '.join(told.pop(word, ['a plug-in']))}"] = new
        self.kept |= wanted.kept
        return wanted._replace(sections=sections, said=told)

    # What both need

    def _refused(
        self,
        found: list[Candidate],
        made: dict[str, Any],
        options: Mapping[str, Any],
        sections: Callable[[dict[str, Any]], dict[str, Any]],
    ) -> dict[str, str]:
        """Take out the entries that a rule refuses, and return why, by what they are called."""
        if not made or not self._new(sections(made), options):
            return {}
        why: dict[str, str] = {}
        for one in [one for one in found if one.name in made]:
            new = self._new(sections({one.name: made[one.name]}), options) if len(made) <= _MANY else ""
            if new or len(made) > _MANY:
                why[one.called] = new or "a rule refuses one of many"
        for one in found:
            if one.called in why:
                made.pop(one.name, None)
        together = self._new(sections(made), options) if made else ""
        if together:
            why |= {one.called: together for one in found if one.name in made}
            made.clear()
        return why

    def _new(self, sections: dict[str, Any], options: Mapping[str, Any]) -> str:
        """Return the first error that a robot with some words has, and without them has not; empty for none."""
        problems = self.problems(self.tree, sections, options)
        return next((one.message for one in problems if one.message not in self.before), "")

    def problems(self, tree: Map, sections: dict[str, Any], options: Mapping[str, Any] | None = None) -> list[Any]:
        """Return the errors of a tree with more sections."""
        output = {"file": "robot.urdf", **(options or {})}
        whole = Imported(tree, []).with_sections({**sections, "outputs": {"urdf": output}}).typed()
        return [*whole.diagnostics, *errors(whole, rules=not whole.diagnostics)]

    def _lowered(self, sections: dict[str, Any]) -> Robot | None:
        whole = Imported(self.tree, []).with_sections(sections).typed()
        return None if whole.diagnostics or errors(whole, rules=False) else whole.robot

    def _written(self, robot: Robot | None, options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return the texts that a URDF has of each hardware block and sensor, by what those are called."""
        brings, found = FORMATS["urdf"].writing.brings, dict[str, list[str]]()
        if robot is None or brings is None:
            return found
        for text in brings(robot, Output("urdf", "urdf", "robot.urdf", {**options, **_UNROUNDED})):
            for one in candidates(_listed(text, self.texts)):
                found.setdefault(one.called, []).append(text)
        return found

    def _of_model(self, made: dict[str, Any], options: Mapping[str, Any]) -> dict[str, list[str]]:
        """Return the sensors of the SDF that a robot becomes, each as if it stood in a <gazebo> of its link."""
        robot, found = self._lowered({SENSORS: made, "urdf_elements": ()}), dict[str, list[str]]()
        if robot is None:
            return found
        text, _ = FORMATS["sdf"].written(
            robot, Output("sdf", "sdf", "robot.sdf", {**options, **_UNROUNDED}), Templates()
        )
        for place in Document.tree(text).iter():
            for sensor in place if place.tag in ("link", "joint") else ():
                if sensor.tag == "sensor":
                    name = sensor.get("name", "")
                    one = Candidate(SENSORS, name, 0, 0, sensor, place.get("name", ""))
                    found.setdefault(one.called, []).append(one.alone)
        return found


def _unwritten(texts: Seq) -> dict[str, str]:
    """Return the elements that no output writes, each with the reason."""
    found: dict[str, str] = {}
    for _, element in trees(texts):
        if element.tag == "transmission":
            found[f'<transmission> "{element.get("name", "")}"'] = "it is of ROS 1: ros2_control has its own"
        for plugin in element if element.tag == "gazebo" else ():
            if plugin.tag == "plugin":
                found[f'plug-in "{plugin.get("name", "")}"'] = "no output writes plug-ins"
    return found


def _differs(one: Candidate, texts: Sequence[str]) -> str:
    """Return what comes out otherwise of a sensor; empty if nothing does."""
    alone, *written = without_collisions([one.alone, *texts])
    wrong = Proof.of([alone], written, Proof.elements()).texts
    return _otherwise(wrong, texts) if wrong else ""


def _otherwise(wrong: Sequence[str], texts: Sequence[str]) -> str:
    """Return why an element that is written again is another one."""
    if not texts:
        return "it would not be written again: its link has no mass that Gazebo keeps it for"
    new = [text for text in wrong if text.endswith("is new")]
    more = [text for text in new if "<sensor" not in text and "<ros2_control" not in text]
    return "written again it would not say the same" + (f": {more[0]}" if more else "")


def _listed(text: str, like: Seq) -> Seq:
    made = Seq(like.span)
    made.put(text, like.span)
    return made


def _bare(tree: Map) -> Map:
    """Return the frames of a robot alone: what decides on how one sensor sits."""
    links: dict[str, Any] = {name: {} for name in tree.get("links") or ()}
    made = put(Map(tree.span, tree.via), {"robot": tree["robot"], "links": links})
    if "joints" in tree:
        made.put("joints", tree["joints"], tree.span, tree.span)
    return made
