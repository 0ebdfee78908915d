"""Elements of XML that a description carries for the URDF: each text is elements, whole and well formed.

The links and joints that they name are there, by their final names, with every prefix. Who reads such an element passes
over a name that it does not know: Gazebo keeps its default friction, a controller waits for a joint that never comes.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.language.schema import named_as
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Joint, Link, Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Related, Source, did_you_mean, nearest
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Instance, Path, locate, prefix_at
from rosorin_compile.source.xml.elements import Found, canonical, damage, found_in, tree_of
from rosorin_compile.source.xml.references import EITHER, FRAME, JOINT, LINK, REFERRING, Reference, references

from .case import Case, links_by_value
from .kinematics import WORLD_FRAMES
from .simulated_names import kept as in_mjcf

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

# What has none of these words names no link and no joint.
_WORDS = ("link", "Link", "joint", "Joint", "reference", "mimic", "body", "frame", "Frame", "<material", "<gazebo ")
_MAX_RELATED = 3
_AROUND = "elements"  # a name that nobody closes by mistake
_CLOSES = r"</(.+)> does not close <(.+)>"


@rule(
    "bad-xml",
    "A text of `urdf_elements` or `mjcf_elements` is not whole elements of XML.",
    "Correct it as the message says.",
    NUMBERS,
)
def well_formed(case: Case) -> Iterator[Diagnostic]:
    """Texts that would make an artifact unreadable, or would end the element that they stand in."""
    of_mjcf = ((path, text) for path, text, _ in in_mjcf(case))
    for path, text in (*kept_texts(case), *of_mjcf):
        wrong = damage(text)
        if wrong:
            yield _damaged(case, path, text, wrong)


def _damaged(case: Case, path: Path, text: str, wrong: str) -> Diagnostic:
    """Return what is wrong with a text that is no XML, at its line where the file has it as it is."""
    from rosorin_compile.source.xml.markup import MarkupError, parse

    example = "<gazebo>...</gazebo>" if "urdf_elements" in path else "<site .../>"
    help = f"write whole elements, such as {example}"
    try:
        parse(Source("", f"<{_AROUND}>{text}</{_AROUND}>"))
    except MarkupError as problem:
        told, span = problem.diagnostic.message, problem.diagnostic.span
        line, column = (span.line, span.column) if span else (1, 1)
        left = re.fullmatch(_CLOSES, told)
        if left and left[1] == _AROUND:  # what stands around is closed too early: something within is still open
            told, line, column = f"<{left[2]}> is not closed", 0, 0
            help = f"add </{left[2]}>"
        elif left and left[2] == _AROUND:
            told = f"</{left[1]}> does not close an open element"
        elif problem.diagnostic.help:
            help = problem.diagnostic.help
        made = case.problem("bad-xml", f"this is no element of XML: {told}", path, help)
        return _at_line(made, text, line, column - (len(_AROUND) + 2 if line == 1 else 0)) if line else made
    return case.problem("bad-xml", f"this is no element of XML: {wrong}", path, help)


def _at_line(made: Diagnostic, text: str, line: int, column: int) -> Diagnostic:
    """Return a diagnostic at a line and column of its text, where that line stands in the file letter by letter."""
    if made.span is None:
        return made
    span = made.span
    first = span.source.line(span.line)[span.column - 1 :]
    there = span.line + line - (0 if first.startswith("|") else 1)
    wanted, written = text.split("\n")[line - 1], span.source.line(there)
    start = written.find(wanted, span.column - 1 if line == 1 and there == span.line else 0)
    if start < 0 or not wanted.strip():
        return made
    return replace(made, span=span._replace(line=there, column=start + max(1, column), length=1))


def kept_texts(case: Case) -> Iterator[tuple[Path, str]]:
    """Yield each text with its path."""
    robot = case.robot
    for index, text in enumerate(robot.urdf_elements):
        yield case.places.get(("urdf_element", str(index)), ("urdf_elements", index)), text
    links, joints = _with_elements(robot)
    for link in links:
        yield from _listed(case.link(link.name), link.urdf_elements)
        for purpose in ("visual", "collision"):
            for index, shape in enumerate(getattr(link, purpose)):
                yield from _listed(case.link(link.name, purpose, index), shape.urdf_elements)
    for joint in joints:
        yield from _listed(case.joint(joint), joint.urdf_elements)


@of_robot
def _with_elements(robot: Robot) -> tuple[list[Link], list[Joint]]:
    """Return the links and the joints that have texts for the URDF, as few do."""
    kinds = links_by_value(robot)
    shaped = {
        kind
        for kind, link in kinds.first.items()
        if any(shape.urdf_elements for shape in (*link.visual, *link.collision))
    }
    links = [link for kind, link in zip(kinds.values, robot.links, strict=True) if link.urdf_elements or kind in shaped]
    return links, [joint for joint in robot.joints if joint.urdf_elements]


def _listed(path: Path, texts: Sequence[str]) -> Iterator[tuple[Path, str]]:
    for index, text in enumerate(texts):
        yield (*path, "urdf_elements", index), text


class Mention(NamedTuple):
    """A name in an element, and where: the path of the text, and the line in it."""

    found: Reference
    line: int
    path: Path


@rule(
    "unknown-reference",
    "A warning: an element of `urdf_elements` names a link, a joint or a material that there is not, or that the URDF "
    "has not. Its readers pass over it. Or the attribute `reference` is misspelt.",
    "Correct the name.",
    NUMBERS,
)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """Names inside kept elements that no link or joint has; each name once, however often it stands there."""
    mentions: dict[tuple[str, str], list[Mention]] = {}
    own: set[str] = set()
    looks = _Materials(case)
    for path, text in kept_texts(case):
        if any(word in text for word in _WORDS):
            for element in found_in(text):
                own.update(_defined(element))
                looks.meet(element, path)
                yield from _misspelt(case, element, path)
                for found in references(element.tags, element.attributes, element.text):
                    mentions.setdefault((found.kind, found.name), []).append(Mention(found, element.line, path))
    if mentions:
        yield from _unknown(case, mentions, own)
    yield from looks.unknown()


def _misspelt(case: Case, element: Found, path: Path) -> Iterator[Diagnostic]:
    """Yield a <gazebo> whose reference is misspelt: it is about the whole robot, not about the link."""
    if element.tags == ("gazebo",):
        for name in element.attributes:
            if name != "reference" and nearest(name, ["reference"]):
                found = Reference(name, FRAME, "", "")
                message = f'<gazebo> has no attribute "{name}", so it is about the whole robot'
                yield _placed(case, message, Mention(found, element.line, path), 'did you mean "reference"?')


def _unknown(case: Case, mentions: dict[tuple[str, str], list[Mention]], own: set[str]) -> Iterator[Diagnostic]:
    robot = case.robot
    links = {*robot.link, *WORLD_FRAMES, "world", *(name for edge in robot.edges for name in (edge.parent, edge.child))}
    names = {LINK: links, JOINT: set(robot.joint), EITHER: {*robot.link, *robot.joint}, FRAME: links}
    real = {**names, LINK: set(robot.link), FRAME: set(robot.link)}
    absent = _absent_from_urdf(case)
    for (kind, name), uses in mentions.items():
        if name in own:
            continue
        sure = [use for use in uses if use.found.sure]
        if name in names[kind]:
            if name in absent and sure:
                yield _not_in_urdf(case, sure)
        elif sure or nearest(name, names[kind]):
            told = sure or uses
            message = f'there is no {kind} "{name}", {told[0].found.where}'
            help = _with_prefix(case, told[0], real[kind])
            help = help or case.suggest(told[0].path, name, real[kind], f"name a {kind} of the robot")
            first = _problem(case, message, told, help)
            yield first
            same = (_placed(case, message, use, help) for use in told[1:])
            yield from (one for one in same if one.span == first.span)  # a part has one text for all its uses


def _with_prefix(case: Case, use: Mention, names: Set[str]) -> str:
    """Return the way out for a name without its prefix: the names that end with it, those of its own part first."""
    name = use.found.name
    longer = sorted(one for one in names if one.endswith(name) and one != name and not one[-len(name) - 1].isalnum())
    via = locate(case.tree, use.path).via
    own = [one for one in longer if via is not None and via.made and via in _makers(case, one)]
    if own:
        return f'did you mean "{own[0]}", as this use of the part makes it?'
    prefix = prefix_at(case.tree, use.path)
    short = [one.removeprefix(prefix) for one in names if prefix and one.startswith(prefix)]
    if nearest(name, short) is not None:
        return did_you_mean(name, short)
    if not longer and nearest(name, names) is None:
        tails = {"_".join(one.split("_")[-name.count("_") - 1 :]): one for one in sorted(names, reverse=True)}
        longer = [tails[near]] if (near := nearest(name, tails)) else []
    if not longer:
        return ""
    choice = " or ".join(f'"{one}"' for one in longer[:_MAX_RELATED])
    return f"did you mean {choice}? names have their prefixes here"


def _makers(case: Case, name: str) -> list[Instance | None]:
    """Return what made the link and the joint of a name."""
    paths = [case.link(name)] if name in case.robot.link else []
    paths += [case.joint(case.robot.joint[name])] if name in case.robot.joint else []
    return [locate(case.tree, path).via for path in paths]


def _absent_from_urdf(case: Case) -> set[str]:
    """Return the links and joints that are not in the URDF, because another node publishes them."""
    carried = case.robot.in_urdf()
    if not carried or not case.feeding(ROBOT_STATE_PUBLISHER):
        return set()
    inside = {name for joint in carried for name in (joint.name, joint.parent, joint.child)}
    return {*case.robot.link, *case.robot.joint} - inside


def _not_in_urdf(case: Case, uses: list[Mention]) -> Diagnostic:
    use = uses[0]
    what = "link" if use.found.name in case.robot.link and use.found.kind != JOINT else "joint"
    message = f'the URDF has no {what} "{use.found.name}", {use.found.where}: robot_state_publisher does not publish it'
    return _problem(case, message, uses, "let robot_state_publisher publish it, or remove the element")


def _problem(case: Case, message: str, uses: list[Mention], help: str) -> Diagnostic:
    first, *others = [_placed(case, message, use, help) for use in uses[: _MAX_RELATED + 1]]
    places = dict.fromkeys(other.span for other in others if other.span != first.span)
    related = tuple(Related("also named here", place) for place in places)
    return replace(first, related=(*related, *first.related))


def _placed(case: Case, message: str, use: Mention, help: str) -> Diagnostic:
    """Return the diagnostic at the very name, where the file has it as it is: below the beginning of the text."""
    made = case.problem("unknown-reference", message, use.path, help, severity=WARNING)
    return at_name(made, use.found.name, use.line)


def at_name(made: Diagnostic, name: str, number: int) -> Diagnostic:
    """Return a diagnostic at a name in a line of its text, where the file has it as it is."""
    if made.span is None:
        return made
    form = re.compile(rf"(?<![\w./-]){re.escape(name)}(?![\w./-])")
    span, column = made.span, made.span.column - 1
    block = span.source.line(span.line)[column : column + 1] in ("|", ">")  # in YAML, its text begins a line below
    line = span.line + number - (0 if block else 1)
    found = form.search(span.source.line(line), column if line == span.line else 0)
    if found:
        return replace(made, span=span._replace(line=line, column=found.start() + 1, length=len(name)))
    return made


class _Materials:
    """Materials by name in elements of a robot or a visual: those of <gazebo> are words of Gazebo."""

    def __init__(self, case: Case) -> None:
        self.case = case
        self.uses: list[Mention] = []
        self.own = {shape.material for link in case.robot.links for shape in link.visual}
        self.looking = False

    def meet(self, element: Found, path: Path) -> None:
        """Take down an element: what stands in a <material> comes before it."""
        tags = element.tags
        if tags[0] == "gazebo":
            return
        if tags[-1] in ("color", "texture") and tags[-2:-1] == ("material",):
            self.looking = True
        elif tags[-1] == "material" and element.attributes.get("name"):
            name = element.attributes["name"]
            if self.looking:
                self.own.add(name)
            else:
                found = Reference(name, "material", "name", "the name of <material>")
                self.uses.append(Mention(found, element.line, path))
            self.looking = False

    def unknown(self) -> Iterator[Diagnostic]:
        """Yield the materials that neither the robot nor an element defines."""
        names = {*self.case.robot.material, *self.own}
        for use in self.uses:
            if use.found.name not in names:
                message = f'there is no material "{use.found.name}", {use.found.where}'
                help = did_you_mean(use.found.name, self.case.robot.material, "define it under materials")
                yield _problem(self.case, message, [use], help)


def _defined(element: Found) -> Iterator[str]:
    """Yield the name that an element gives a link or joint of its own, as SDF within <gazebo> does."""
    name = element.attributes.get("name")
    if name and element.tags[0] not in REFERRING and element.tags[-1] in ("link", "joint", "body", "virtual_joint"):
        yield name


@rule(
    "duplicate-xml",
    "A warning: two elements of `urdf_elements` have one name where their reader takes one: a `<ros2_control>`, a "
    "`<transmission>`, a plug-in, a sensor.",
    "Give each a name of its own; in a part `${prefix}` makes it so.",
    NUMBERS,
)
def own_names(case: Case) -> Iterator[Diagnostic]:
    """Elements that a part brings with each use, and that are called the same each time."""
    first: dict[tuple[str, ...], Path] = {}
    for section in named_as("hardware block"):
        first |= {("<ros2_control>", name): (section, name) for name in case.tree.get(section) or ()}
    ours = _brought(case)
    for path, text in kept_texts(case):
        if not any(f"<{tag}" in text for tag in _ONCE):
            continue
        try:
            elements = tree_of(f"<all>{text}</all>")
        except ValueError:
            continue
        for element in elements:
            for what, name, *key in _names_of(element):
                if what == "<sensor>" and name in ours:
                    help = "remove this one, or leave out ours: gazebo: [] in the sensor"
                    message = f'an output has a {what} "{name}" for Gazebo without it'
                    yield case.problem("duplicate-xml", message, path, help, severity=WARNING)
                    continue
                before = first.setdefault((what, name, *key), path)
                if before is path:
                    continue
                via = locate(case.tree, path).via
                help = "give each a name of its own"
                help += ": in a part, write ${prefix} before it" if via is not None and via.made else ""
                message = f'two {what} of the robot are called "{name}"'
                if key and key[-1].startswith("<"):
                    message = f'the same {what} "{name}" stands twice'
                    help = "one is enough, or their settings differ"
                related = [_other(case, before, path)]
                yield case.problem("duplicate-xml", message, path, help, related=related, severity=WARNING)


def _brought(case: Case) -> set[str]:
    """Return the sensors that outputs have for Gazebo, by the names that they have there."""
    asked = any(output.options.get("gazebo") for output in case.robot.outputs)
    return {one.name for sensor in case.robot.sensors for one in sensor.gazebo} if asked else set()


def _other(case: Case, before: Path, path: Path) -> Related:
    """Return where the first of two elements came from; of one text that a part brings twice, its first use."""
    first, second = locate(case.tree, before), locate(case.tree, path)
    if first.via is not None and first.span == second.span:
        return Related(f"the other one: {first.via.message}", first.via.span)
    return Related("the other one", first.span)


_ONCE = ("ros2_control", "transmission", "plugin", "sensor")


def _names_of(element: Element) -> Iterator[tuple[str, ...]]:
    """Yield what has a name of its own in an element, its name, and what else has to be the same.

    In the newer Gazebo the name of a plug-in is that of its class: there may be several of those, with other settings.
    """
    name = element.get("name", "")
    if element.tag in ("ros2_control", "transmission") and name:
        yield f"<{element.tag}>", name
    for child in element if element.tag == "gazebo" else ():
        name, reference = child.get("name", ""), element.get("reference", "")
        if child.tag == "plugin" and name:
            yield "<plugin>", name, reference, *([canonical(child)] if "::" in name else [])
        elif child.tag == "sensor" and name:
            yield "<sensor>", name, reference
