"""Rules about names: invisible or similar letters, swapped letters, and leading slashes."""

import re
from collections import Counter
from collections.abc import Iterator, Mapping

from rosorin_compile.language.symbols import Symbol
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Span
from rosorin_compile.source.messages import Offer, move_to_name
from rosorin_compile.source.rule_registry import ARGUMENTS, FRAMES, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import difference, foreign, hidden_letter, in_words, look, suggest, swaps

from .case import Case
from .magnitudes import NOT_XML

_WORDS = re.compile(r"[^\W\d_]+")
# Common words in names of robots, files and packages; no two of them differ only by two swapped letters.
_USUAL_WORDS = """
amcl back base broadcaster calf camera caster chassis color components contact control controller controllers depth
drive driver effector elbow finger fixed flange floating foot footprint force forearm frame frames front GenericSystem
gripper hand height infra joint json laser launch left lidar link localization lower mapping mecanum mock model motor
mount odom optical pan pose position rear right robot roller scan scene sensor servo shoulder slam state static
steering system thigh tool toolbox torque trajectory trunk upper urdf velocity wheel wrist yaml
"""
_USUAL, _ENDINGS = frozenset(_USUAL_WORDS.split()), frozenset(("xml", "sdf", "svg"))


def _names(case: Case) -> Iterator[Symbol]:
    yield from (one for one in case.definitions if one.path[0] != "edges")
    frames: dict[str, Path] = {}
    for index, edge in enumerate(case.robot.edges):
        frames.setdefault(edge.parent, case.edge(index, "parent"))
        frames.setdefault(edge.child, case.edge(index, "child"))
    yield from (Symbol("frame", frame, path) for frame, path in frames.items() if frame not in case.robot.link)


@rule("invisible-letter", "A name has an invisible letter.", "Retype the name.", ARGUMENTS, "link or joint", "lenient")
@rule("names-look-alike", "A warning: names look alike.", "Rename one of them.", ARGUMENTS, "link or joint", "always")
def letters(case: Case) -> Iterator[Diagnostic]:
    """Report names with invisible or foreign letters, and names that look like another name."""
    first: dict[tuple[str, str], Symbol] = {}
    for one in _names(case):
        kind = "link" if one.kind == "frame" else one.kind
        # Names of materials and outputs may differ only in case, as they do in some imported robots.
        other = first.setdefault((kind, look(one.name, kind not in ("material", "output"))), one)
        letter, strange, related = hidden_letter(one.name), foreign(one.name), []
        id, severity, message = "names-look-alike", WARNING, f'{one.kind} "{one.name}" '
        if letter and re.search(NOT_XML, one.name):  # another rule reports characters that XML does not allow
            continue
        if letter:
            # Users cannot suppress errors about materials or robots, so these are only warnings for imported robots.
            is_mild = case.robot.source.status == "imported" and one.kind in ("material", "robot")
            id, severity = "invisible-letter", WARNING if is_mild else ERROR
            message += f"contains an invisible character: {in_words(letter)}"
        elif other.name != one.name and not hidden_letter(other.name):
            related = [case.related_place("the similar name", other.path, key=other.key)]
            message += f'differs from {other.kind} "{other.name}" only in {difference(one.name, other.name)}'
        elif strange and other.name == one.name:
            message += f"mixes Latin letters with a look-alike of another script: {in_words(strange)}"
        else:
            continue
        help = "" if letter or related else "retype it in one script"
        yield case.problem(id, message, one.path, help, related=related, severity=severity, key=one.key)


@rule("letters-swapped", help="Correct it.", topic=ARGUMENTS, accept="link or joint", imported="always")
def swapped_letters(case: Case) -> Iterator[Diagnostic]:
    """A warning: a word in a name, or a file extension, is a known word with two letters swapped."""
    named = [*_names(case), *(Symbol(*spelt) for spelt in case.symbols.spelt())]
    for output in case.robot.outputs:  # the symbol table lacks names of files and topics
        path: Path = ("outputs", output.name)
        named.append(Symbol("file", output.file, (*path, "file")))
        for option, value in output.options.items():
            for word, name in value.items() if isinstance(value, Mapping) else ():
                if option == "rename" or word == "topic":
                    named.append(Symbol("frame" if option == "rename" else "topic", name, (*path, option, word)))
    counts = Counter(_WORDS.findall("\n".join(one.name for one in named)))
    usual = _USUAL.union(word for word, number in counts.items() if number > 1)
    slips: dict[str, str] = {}
    for word, number in counts.items():
        if word not in _USUAL:  # common words are spelt correctly
            known = _ENDINGS if len(word) < 4 else usual if number == 1 else _USUAL
            right = next((one for one in swaps(word) if one in known), None)
            slips |= {word: right} if right else {}
    reported: set[Span | None] = set()
    for one in named:
        slip = next(((word, slips[word]) for word in _WORDS.findall(one.name) if word in slips), None)
        if slip is not None:
            fixed = one.name.replace(*slip)
            message = f'{one.kind} "{one.name}" contains "{slip[0]}", maybe a misspelling of "{slip[1]}"'
            found = case.problem("letters-swapped", message, one.path, suggest(fixed), key=one.key)
            found = move_to_name(found, Offer(one.name, fixed))
            if found.span not in reported:  # a part that is used twice defines its names at the same position
                reported.add(found.span)
                yield found


@rule("leading-slash", help="Remove the slash.", topic=FRAMES, accept="link or joint", imported="always")
def slashes(case: Case) -> Iterator[Diagnostic]:
    """A warning: a name begins with `/`. tf2 strips the slash when it stores a frame, and rejects it in lookups."""
    for one in _names(case):
        if one.name.startswith("/") and one.kind in ("link", "frame", "joint"):
            reader = "controllers split names at a slash" if one.kind == "joint" else "tf2 rejects such frame names"
            message = f'{one.kind} "{one.name}" begins with "/": {reader}'
            yield case.problem("leading-slash", message, one.path, key=one.key)
