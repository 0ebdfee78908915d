"""Elements of MJCF that a description carries: what may not stand there, and names in them that there are not.

That they are whole elements is said by ``xml_elements``. A body or a joint that only MuJoCo knew would be missing in
every other artifact.
"""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.language import element_names
from rosorin_compile.language.element_names import BODY, GEOM, JOINT
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.simulated_names import WORDS, Names, kept, simulates
from rosorin_compile.rules.xml_elements import at_name
from rosorin_compile.source.diagnostics import Diagnostic, Help, Suggestion
from rosorin_compile.source.rule_registry import SIMULATED, rule
from rosorin_compile.source.xml.elements import Found, found_in

# What a description has words for, wherever it stands, and the way out.
_IN_WORDS = {
    "body": "make it a link, with a joint of type fixed where it does not move",
    "joint": "write it under joints of the description",
    "freejoint": "say base: free in the output of the MJCF",
    "inertial": "write it under inertial of the link",
    "composite": "make its bodies links",
    "attach": "use a part, or include its file",
    "include": "write its elements here, or include its file",
}
# Tags that mean something else in these sections.
_OTHERWISE = {"joint": ("tendon", "equality")}
_IN_BODIES = ("geom", "site", "camera", "light", "frame", "replicate", "flexcomp", "plugin")


@rule(
    "mjcf-element",
    "An element of `mjcf_elements` may not stand there: a body, a joint, `<compiler>`, a section within a body, an "
    "element of a body at the top.",
    "As the message says.",
    SIMULATED,
)
def placed(case: Case) -> Iterator[Diagnostic]:
    """Elements that the language has words for, or that MuJoCo does not take at that place."""
    for path, text, top in kept(case):
        for found in found_in(text):
            wrong = _misplaced(case, found, top)
            if wrong:
                message, help = wrong
                made = case.problem("mjcf-element", message, path, help)
                yield at_name(made, found.tags[-1], found.line)
                break


def _misplaced(case: Case, found: Found, top: bool) -> tuple[str, Help] | None:
    """Return what is wrong with where an element stands, and the way out."""
    tag, first = found.tags[-1], found.tags[0]
    if tag in _IN_WORDS and not (top and first in _OTHERWISE.get(tag, ())) and not (top and first == "default"):
        return f"<{tag}> stands in elements of MJCF: no other artifact would know of it", _IN_WORDS[tag]
    if tag == "flexcomp" and case.robot.poses:
        message = "<flexcomp> adds joints that no pose places: MuJoCo refuses the keyframes"
        return message, "leave the poses to a description without it"
    if len(found.tags) > 1:
        return None
    if top and tag == "compiler":
        return "<compiler> would change what all numbers of the MJCF mean", "leave it out; angles are in radians here"
    if top and tag not in element_names.SECTIONS:
        where = (
            "write it in a link"
            if tag in _IN_BODIES
            else Suggestion(tag, element_names.SECTIONS, "write a whole section")
        )
        return f"<{tag}> is no section of an MJCF", where
    if not top and tag in element_names.SECTIONS:
        return f"<{tag}> is a section of the MJCF, and stands in a link", "write it under mjcf_elements at the top"
    if not top and tag not in _IN_BODIES:
        return f"<{tag}> is no element of a body", Suggestion(tag, _IN_BODIES, "write one of them")
    return None


@rule(
    "unknown-in-mjcf",
    "An element of `mjcf_elements` names a body, a joint, a site, a geom, a class or the like that there is not.",
    "Correct the name.",
    SIMULATED,
)
def unknown_names(case: Case) -> Iterator[Diagnostic]:
    """Names inside elements of MJCF that the MJCF has not; each once."""
    if not simulates(case.robot):
        return
    names = Names(case)
    seen: set[tuple[str, str]] = set()
    flexible = any("<flexcomp" in text for _, text, _ in kept(case))
    for path, text, top in kept(case):
        elements = found_in(text)
        if any(_misplaced(case, found, top) for found in elements):
            continue
        for found in elements:
            for one in element_names.used(found, top):
                if (one.kind, one.name) in seen or (flexible and one.kind == BODY):
                    continue
                if not _is_there(case, names, one.kind, one.name):
                    seen.add((one.kind, one.name))
                    word = WORDS.get(one.kind, one.kind) if one.kind != GEOM else GEOM
                    message = f'there is no {word} "{one.name}", {one.where}'
                    if one.kind == JOINT and one.name in case.robot.joint:
                        message = f'joint "{one.name}", {one.where}, is no joint in the MJCF: it is '
                        message += case.robot.joint[one.name].type
                    known = names.of(one.kind)
                    if one.kind == element_names.MATERIAL:
                        known = {f"{case.robot.name}_{name}" for name in known}
                    help = case.suggest(path, one.name, known, f"name a {word} of the robot or of these elements")
                    yield at_name(case.problem("unknown-in-mjcf", message, path, help), one.name, found.line)


def _is_there(case: Case, names: Names, kind: str, name: str) -> bool:
    """Say whether the MJCF has something of a kind under a name; of kinds that nobody gives here, nobody knows."""
    own = f"{case.robot.name}_"
    if kind == element_names.CLASS and (name.startswith(own) or name in ("main", case.robot.name)):
        return True
    if kind == element_names.MATERIAL:  # in the MJCF the names of those of the robot begin with its own
        given = {one.name for one in names.given if one.kind == kind}
        return name in given or (name.startswith(own) and name.removeprefix(own) in names.by_kind[kind])
    if kind == element_names.MESH and name.startswith(own):
        return True
    return names.has(kind, name) or _in_copies(case, kind, name)


def _in_copies(case: Case, kind: str, name: str) -> bool:
    """Say whether <replicate> or <flexcomp> may make a name: that of one of its elements with something behind it."""
    for _, text, top in kept(case):
        if "<replicate" not in text and "<flexcomp" not in text:
            continue
        for found in found_in(text):
            if any(one.kind == kind and name.startswith(one.name) for one in element_names.given(found, top)):
                return True
    return False
