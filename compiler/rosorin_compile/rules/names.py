"""Names: letters that nobody sees, names that only look alike, and the slash that tf2 takes for none of the name."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..diagnostics import ERROR, WARNING, Diagnostic
from ..diagnostics.letters import difference, foreign, in_words, look, unseen
from ..diagnostics.registry import ARGUMENTS, FRAMES, rule
from ..frontend.tree import Path, exists
from ..startup.records import NamedTuple
from .case import Case
from .remarkable import NOT_XML

AFTER = "values"

# Sections whose keys are names, with the word for one of them; those of links and joints are frames and joints too.
_SECTIONS = {
    "sensors": "sensor",
    "publishers": "publisher",
    "servos": "servo group",
    "poses": "pose",
    "control": "hardware block",
    "controllers": "controller",
    "modes": "mode",
    "materials": "material",
    "outputs": "output",
}
# Where names that differ in case alone are nothing to speak of, as with the colours of a bought robot.
_BY_CASE = ("material", "output")


class Name(NamedTuple):
    """A name, what it is the name of, and the place that gives it; ``key`` where that is a key of the description."""

    name: str
    kind: str
    path: Path
    key: bool


def names(case: Case) -> Iterator[Name]:
    """Yield every name that the description gives; what follows from another name is none."""
    for link in dict.fromkeys((*(case.tree.get("links") or ()), *case.robot.link)):
        path = case.link(link)
        yield Name(link, "link" if path[0] == "links" else "frame", path, path[0] == "links")
    taken = set(case.robot.link)
    for index, edge in enumerate(case.robot.edges):
        for which, frame in (("parent", edge.parent), ("child", edge.child)):
            if frame not in taken:
                taken.add(frame)
                yield Name(frame, "frame", case.edge(index, which), False)
    for joint in case.robot.joints:
        path = case.joint(joint)
        if path[0] == "joints" or exists(case.tree, (*path, "joint")):
            yield Name(joint.name, "joint", path if path[0] == "joints" else (*path, "joint"), path[0] == "joints")
    for section, kind in _SECTIONS.items():
        for name in case.tree.get(section) or ():
            yield Name(name, kind, (section, name), True)
    for name, entry in (case.tree.get("publishers") or {}).items():
        if entry and "node" in entry:
            yield Name(entry["node"], "node", ("publishers", name, "node"), False)
    yield Name(case.robot.name, "robot", ("robot",), False)


@rule(
    "invisible-letter",
    "A name has a letter that nobody sees: a control character, a mark of writing direction, a letter without width.",
    "Remove it: type the name anew.",
    ARGUMENTS,
    accept="link or joint",
    imported="lenient",
)
@rule(
    "names-look-alike",
    "A warning: two names differ in upper and lower case alone, in the Unicode form of a letter, or in a letter of "
    "another script; or such a letter stands in a Latin word.",
    "Rename one; type the name anew.",
    ARGUMENTS,
    accept="link or joint",
    imported="always",
)
@rule(
    "leading-slash",
    "A warning: a name begins with `/`. tf2 drops the slash of a frame that is published, and refuses to look one up "
    "that has it.",
    "Write it without.",
    FRAMES,
    accept="link or joint",
    imported="always",
)
def letters(case: Case) -> Iterator[Diagnostic]:
    """Names that are not what they look like."""
    kinds: dict[str, list[Name]] = {}
    for name in names(case):
        kinds.setdefault("link" if name.kind == "frame" else name.kind, []).append(name)
    for kind, group in kinds.items():
        text = "".join(one.name for one in group)
        plain = text.isascii() and text.isprintable()
        if not plain:
            yield from _unseen(case, group)
        if not plain or len({look(one.name) for one in group}) < len(group):
            yield from _alike(case, group, by_case=kind not in _BY_CASE)
        if kind in ("link", "joint") and "/" in text:
            yield from _slashes(case, group)


def _unseen(case: Case, group: Iterable[Name]) -> Iterator[Diagnostic]:
    imported = case.robot.source.status == "imported"
    for one in group:
        letter = unseen(one.name)
        if letter and not NOT_XML.search(one.name):  # else no file can carry it, which is said
            message = f'{one.kind} "{one.name}" has a letter that nobody sees: {in_words(letter)}'
            # What no entry of accept can name does not keep the robot of somebody else out.
            lets_in = imported and one.kind in ("material", "robot")
            severity, help = WARNING if lets_in else ERROR, "type the name anew, without it"
            yield case.problem("invisible-letter", message, one.path, help, severity=severity, key=one.key)


def _alike(case: Case, group: list[Name], by_case: bool) -> Iterator[Diagnostic]:
    """Yield a warning for each name that looks like one before it, and for a letter that only seems to belong there."""
    first: dict[str, Name] = {}
    for one in group:
        twin = first.setdefault(look(one.name, by_case), one)
        strange = foreign(one.name)
        if unseen(one.name) or unseen(twin.name):  # which is said, and the cause
            continue
        if twin.name != one.name:
            message = f'{one.kind} "{one.name}" differs from {twin.kind} "{twin.name}" in '
            message += f"{difference(one.name, twin.name)} alone"
            related = [case.related("the other one", twin.path, key=twin.key)]
            help = "give one of them another name"
        elif strange:
            message = f'{one.kind} "{one.name}" has a letter of another script in a Latin word: {in_words(strange)}'
            related, help = [], "type the name anew: other programs look for it in Latin letters"
        else:
            continue
        yield case.problem("names-look-alike", message, one.path, help, related=related, severity=WARNING, key=one.key)


def _slashes(case: Case, group: list[Name]) -> Iterator[Diagnostic]:
    taken = {one.name for one in group}
    for one in group:
        bare = one.name.lstrip("/")
        if bare == one.name:
            continue
        if one.kind == "joint":
            message = f'joint "{one.name}" begins with "/", by which controllers part a joint from its interface'
        else:
            also = ", a frame that there is already" if bare in taken else ""
            message = f'the frame "{one.name}" begins with "/": tf2 publishes it as "{bare}"{also}, and refuses to look'
            message += f' up "{one.name}"'
        help = f'write "{bare}"' if bare else "give it a name"
        yield case.problem("leading-slash", message, one.path, help, severity=WARNING, key=one.key)
