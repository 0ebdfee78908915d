"""Names: invisible letters, names that look alike, swapped letters, and the slash that tf2 drops."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.language.schema import sections
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Span, swaps
from rosorin_compile.source.messages import Offer, placed
from rosorin_compile.source.rule_registry import ARGUMENTS, FRAMES, rule
from rosorin_compile.source.tree import Path, exists
from rosorin_compile.source.wording import difference, foreign, in_words, look, unseen

from .case import Case
from .magnitudes import NOT_XML

# Links and joints have names that come from elsewhere, too.
_APART = ("link", "joint")
_WORDS = re.compile(r"[^\W\d_]+")
# Words of which names of robots, files and packages are made; none is another word with two letters swapped.
_USUAL_WORDS = """
amcl back base broadcaster calf camera caster chassis color components contact control controller controllers depth
drive driver effector elbow finger fixed flange floating foot footprint force forearm frame frames front GenericSystem
gripper hand height infra joint json laser launch left lidar link localization lower mapping mecanum mock model motor
mount odom optical pan pose position rear right robot roller scan scene sensor servo shoulder slam state static
steering system thigh tool toolbox torque trajectory trunk upper urdf velocity wheel wrist yaml
"""
_USUAL = frozenset(_USUAL_WORDS.split())
# Where names that differ in case alone are nothing to speak of, as with the colours of a bought robot.
_BY_CASE = ("material", "output")


class Name(NamedTuple):
    """A name, what it is the name of, and the place that gives it; ``key`` where that is a key of the description."""

    name: str
    kind: str
    path: Path
    key: bool


def named_sections() -> Iterator[tuple[str, str]]:
    """Yield the sections whose keys are names, with the word for one; those of links and joints are told apart."""
    for section, node in sections().items():
        if node.called and node.keys is not None and node.keys.gives and node.keys.gives not in _APART:
            yield section, node.called


def names(case: Case) -> Iterator[Name]:
    """Yield every name that the description gives; what follows from another name is none."""
    for link in dict.fromkeys((*case.section("links"), *case.robot.link)):
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
    for section, called in named_sections():
        for name in case.section(section):
            yield Name(name, called, (section, name), True)
    for name, entry in case.section("publishers").items():
        if entry and "node" in entry:
            yield Name(entry["node"], "node", ("publishers", name, "node"), False)
    yield Name(case.robot.name, "robot", ("robot",), False)


@rule("invisible-letter", "A name has an invisible letter.", "Type it again.", ARGUMENTS, "link or joint", "lenient")
@rule("names-look-alike", "A warning: two names look alike.", "Rename one.", ARGUMENTS, "link or joint", "always")
@rule("letters-swapped", "A warning: a word has two letters swapped.", "Fix it.", ARGUMENTS, "link or joint", "always")
@rule(
    "leading-slash", "A warning: a name begins with `/`; tf2 drops it.", "Drop it.", FRAMES, "link or joint", "always"
)
def letters(case: Case) -> Iterator[Diagnostic]:
    """Names that are not what they look like."""
    kinds: dict[str, list[Name]] = {}
    named = list(names(case))
    yield from _misspelt(case, [*named, *_further(case)])
    for name in named:
        kinds.setdefault("link" if name.kind == "frame" else name.kind, []).append(name)
    for kind, group in kinds.items():
        text = "".join(one.name for one in group)
        is_plain = text.isascii() and text.isprintable()
        if not is_plain:
            yield from _unseen(case, group)
        if not is_plain or len({look(one.name) for one in group}) < len(group):
            yield from _alike(case, group, by_case=kind not in _BY_CASE)
        if kind in ("link", "joint") and "/" in text:
            yield from _slashes(case, group)


def _further(case: Case) -> Iterator[Name]:
    """Yield names of files, topics, plugins, packages and nodes: nothing else of the description refers to them."""
    for output in case.robot.outputs:
        path: Path = ("outputs", output.name)
        yield Name(output.file, "file", (*path, "file"), False)
        for key, value in output.options.items():
            for word, name in value.items() if isinstance(value, Mapping) else ():
                if key == "rename" or word == "topic":
                    yield Name(name, "frame" if key == "rename" else "topic", (*path, key, word), False)
    yield from (Name(name, called, path, is_key) for called, name, path, is_key in case.symbols.spelt())
    for joint in case.robot.joints:
        if joint.publisher.kind == STATIC_TRANSFORM_PUBLISHER:
            path = (*case.publisher(joint), STATIC_TRANSFORM_PUBLISHER)
            if exists(case.tree, path):
                yield Name(joint.publisher.name, "node", path, False)


def _misspelt(case: Case, named: list[Name]) -> Iterator[Diagnostic]:
    """Yield a warning for each word that occurs once, and is another word with two letters swapped."""
    counts = Counter(_WORDS.findall("\n".join(one.name for one in named)))
    usual = _USUAL.union(word for word, number in counts.items() if number > 1)
    slips: dict[str, str] = {}
    for word, number in counts.items():
        if len(word) > 3 and word not in _USUAL:  # a word that occurs several times was chosen
            right = next((one for one in swaps(word) if one in (usual if number == 1 else _USUAL)), None)
            slips |= {word: right} if right else {}
    reported: set[Span | None] = set()
    for one in named:
        words = _WORDS.findall(one.name) if slips else ()
        slip = next(((word, slips[word]) for word in words if word in slips), None) or _ending(case, one)
        if slip is not None:
            message = f'{one.kind} "{one.name}" has "{slip[0]}", which looks like "{slip[1]}" with two letters swapped'
            fixed = one.name.replace(*slip)
            found = case.problem("letters-swapped", message, one.path, f'did you mean "{fixed}"?', key=one.key)
            found = placed(found, Offer(one.name, fixed))
            if found.span not in reported:  # a use of a part makes several names
                reported.add(found.span)
                yield found


def _ending(case: Case, one: Name) -> tuple[str, str] | None:
    """Return the ending of the file of an output, and the one that it should have, if two letters are swapped."""
    output = (
        next((output for output in case.robot.outputs if output.name == one.path[1]), None)
        if one.kind == "file"
        else None
    )
    format = case.formats.get(output.backend) if output else None
    ending = one.name.rpartition(".")[2]
    endings = [format.file.rpartition(".")[2], *(known.lstrip(".") for known in format.endings)] if format else []
    right = next((known for known in swaps(ending) if known in endings), None)
    return (f".{ending}", f".{right}") if right and ending not in endings else None


def _unseen(case: Case, group: Iterable[Name]) -> Iterator[Diagnostic]:
    for one in group:
        letter = unseen(one.name)
        if letter and not NOT_XML.search(one.name):  # else no file can carry it, which is reported
            # ``accept`` can name no material or robot: these do not prevent the import of somebody else's robot.
            is_mild = case.robot.source.status == "imported" and one.kind in ("material", "robot")
            message = f'{one.kind} "{one.name}" has an invisible letter: {in_words(letter)}'
            severity = WARNING if is_mild else ERROR
            yield case.problem("invisible-letter", message, one.path, severity=severity, key=one.key)


def _alike(case: Case, group: list[Name], by_case: bool) -> Iterator[Diagnostic]:
    """Yield a warning for each name that looks like one before it, and for a letter of another script."""
    first: dict[str, Name] = {}
    for one in group:
        other = first.setdefault(look(one.name, by_case), one)
        strange = foreign(one.name)
        if unseen(one.name) or unseen(other.name):  # which is reported, and the cause
            continue
        if other.name != one.name:
            message = f'{one.kind} "{one.name}" differs from {other.kind} "{other.name}" only in '
            message += difference(one.name, other.name)
            related = [case.related("the other one", other.path, key=other.key)]
            help = "give one of them another name"
        elif strange:
            message = f'{one.kind} "{one.name}" has a letter of another script in a Latin word: {in_words(strange)}'
            related, help = [], "type the name again: other programs look for it in Latin letters"
        else:
            continue
        yield case.problem("names-look-alike", message, one.path, help, related=related, key=one.key)


def _slashes(case: Case, group: list[Name]) -> Iterator[Diagnostic]:
    taken = {one.name for one in group}
    for one in group:
        bare = one.name.lstrip("/")
        if bare == one.name:
            continue
        message = f'joint "{one.name}" begins with "/", by which controllers separate a joint from its interface'
        if one.kind != "joint":
            also = ", an existing frame" if bare in taken else ""
            message = f'the frame "{one.name}" begins with "/": tf2 publishes it as "{bare}"{also}, and refuses to look'
            message += f' up "{one.name}"'
        help = f'write "{bare}"' if bare else "give it a name"
        yield case.problem("leading-slash", message, one.path, help, key=one.key)
