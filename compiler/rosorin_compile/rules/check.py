"""Run the rules over a robot."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.language.accepting import accepted, unused
from rosorin_compile.language.accepting import settled as without_accepted
from rosorin_compile.language.expand.provenance import USED
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.lower.sections import is_resolved
from rosorin_compile.language.lower.shapes import RULES as _OF_SHAPES
from rosorin_compile.language.section_registry import plugged as sections_of_plugins
from rosorin_compile.model import Robot
from rosorin_compile.model.sections import own_sections
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Span
from rosorin_compile.source.plugins import Plugin, aside, broken, diagnostic_of, failed, load
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import OF_PLUGINS, Check, Rule, check_texts, checks_of, find
from rosorin_compile.source.tree import Map
from rosorin_compile.source.tree import Path as TreePath

from . import (
    bodies,
    conditions,
    containment,
    drive,
    frames,
    joints,
    kinematics,
    lacking,
    magnitudes,
    materials,
    mimic,
    misplaced_elements,
    mjcf_elements,
    names,
    outputs,
    poses,
    publishers,
    ranges,
    servos,
    sight,
    signs,
    simulated_marks,
    simulated_names,
    simulated_values,
    sizes,
    stamps,
    stand_ins,
    tf_tree,
    two_words,
    xml_elements,
)
from .case import Case
from .magnitudes import collect

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

# The modules whose checks run, in this order; then those of sections for ROS and MuJoCo.
_MODULES = (
    kinematics,
    frames,
    joints,
    mimic,
    drive,
    bodies,
    sizes,
    lacking,
    ranges,
    servos,
    signs,
    conditions,
    containment,
    publishers,
    tf_tree,
    stamps,
    poses,
    outputs,
    magnitudes,
    materials,
    xml_elements,
    misplaced_elements,
    simulated_names,
    simulated_values,
    mjcf_elements,
    simulated_marks,
    two_words,
    stand_ins,
    names,
    sight,
)


@cache
def checks() -> tuple[Check, ...]:
    """Return the checks of the tool itself, in the order in which they run."""
    own = (check for module in _MODULES for check in checks_of(module))
    return (*own, *(check for section in own_sections() for check in section.checks))


class Plugged(NamedTuple):
    """The checks that plug-ins add, and what is wrong with plug-ins of this kind."""

    checks: tuple[tuple[Plugin, Check], ...]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged() -> Plugged:
    """Return the checks of plug-ins, and what is wrong with their rules, those of sections included."""
    loaded, diagnostics = load("rules", Check, _ids, lambda id: bool(find([id])))
    of_sections = [(plugin, check) for plugin, one in sections_of_plugins().sections for check in one.checks]
    wrong = [(plugin, problem) for plugin, check in of_sections if (problem := _wrong(check))]
    refused = [broken(plugin, f"has a check that is none: {problem}") for plugin, problem in wrong]
    plugged = Plugged(loaded, (*diagnostics, *refused))
    OF_PLUGINS.update((rule.id, rule) for _, check in plugged.checks for rule in check.rules)
    return plugged


def _wrong(check: Check) -> str:
    """Return what is wrong with the rules of a check; empty if nothing is."""
    try:
        _ids(check)
    except (TypeError, ValueError) as problem:
        return str(problem)
    return ""


def _ids(check: Check) -> list[str]:
    """Return the ids of a plug-in's check. Raises ValueError if they are none."""
    for rule in check.rules:
        check_texts(rule)
        if not is_id(rule.id):
            raise ValueError(f'"{rule.id}" is no id of a rule: small letters, digits and single hyphens')
        if rule.accept not in _OF or rule.imported not in _IMPORTED:
            raise ValueError(f"accept of {rule.id} is one of {_OF}, imported one of {_IMPORTED}")
    if not check.rules:
        raise ValueError("it declares no rule; put @rule above the function")
    return [rule.id for rule in check.rules]


_OF = ("", "link", "joint", "link or joint")
_IMPORTED = ("", "always", "lenient")


def is_id(text: str) -> bool:
    """Say whether a text has the form of an id: kebab-case."""
    return all(word.isascii() and word.isalnum() and word == word.lower() for word in text.split("-"))


@cache
def acceptable() -> Mapping[str, Rule]:
    """Return the rules that a description may accept, by id; all else cannot be built, or would be built wrongly."""
    of_sections = (check for _, section in sections_of_plugins().sections for check in section.checks)
    all_checks = (*checks(), *(check for _, check in plugged().checks), *of_sections)
    rules = (*_OF_SHAPES, *(rule for check in all_checks for rule in check.rules))
    return {rule.id: rule for rule in sorted(rules, key=lambda rule: rule.id) if rule.accept}


def check(
    robot: Robot,
    tree: Map,
    places: Mapping[tuple[str, str], TreePath],
    formats: Mapping[str, Format],
    scope: Scope | None = None,
    wanted: Collection[str] = (),
) -> list[Diagnostic]:
    """Return what is wrong with the meaning of a description, and what is worth a note.

    ``places`` leads from a joint or a link, by kind and name, to its path in the tree (see ``lower``); ``formats`` are
    those that outputs may name, ``scope`` has what the names of the description stand for, ``wanted`` as in ``Case``.
    """
    case = Case(robot, tree, places, collect(tree), formats, scope, wanted)
    diagnostics: list[Diagnostic] = []
    for number, one in enumerate(checks()):
        Progress.step("checking", number, len(checks()))
        diagnostics += one(case)
    diagnostics += [diagnostic for plugin, one in plugged().checks for diagnostic in _guarded(plugin, one, case)]
    for plugin, section in sections_of_plugins().sections:
        if section in robot.sections and is_resolved(robot, case.symbols, section.name):
            diagnostics += [found for one in section.checks for found in _guarded(plugin, one, case)]
    return _causes(tree, _joined(tree, diagnostics))


def _guarded(plugin: Plugin, check: Check, case: Case) -> list[Diagnostic]:
    """Return what a plug-in's check finds until it does something wrong, and that."""
    ids = [rule.id for rule in check.rules]
    found: list[Diagnostic] = []
    try:
        with aside(plugin):
            for diagnostic in check(case):
                if not isinstance(diagnostic, Diagnostic) or diagnostic.rule not in ids:
                    what = f"yields {str(diagnostic)[:80]}, no Diagnostic of its rules ({', '.join(ids)})"
                    return [*found, broken(plugin, what)]
                found.append(diagnostic_of(diagnostic))
    except (Exception, SystemExit) as problem:
        found.append(failed(plugin, problem))
    return found


def _joined(tree: Map, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics, those on one value that is used many times as one; what is accepted is so by name."""
    found: dict[object, Diagnostic] = {}
    for diagnostic in diagnostics:
        uses = tuple(related for related in diagnostic.related if related.message == USED)
        alone = not uses or accepted(tree, diagnostic, acceptable())
        key: object = (len(found), diagnostic) if alone else (diagnostic.rule, diagnostic.span)
        if key not in found:
            found[key] = diagnostic
            continue
        first = found[key].related
        more = tuple(use for use in uses if use not in first)
        last = max(index for index, related in enumerate(first) if related.message == USED) + 1
        found[key] = replace(found[key], related=(*first[:last], *more, *first[last:]))
    return list(found.values())


# What is said of a number because of another one: a size, a limit.
_COMPARING = (
    "centre-outside",
    "collision-elsewhere",
    "inertia-implausible",
    "mass-implausible",
    "mimic-beyond-limit",
    "pose-beyond-limit",
    "size-implausible",
)
# Remarks that hold or not by all numbers of a robot together: a wrong one alone is reason enough.
_OF_ALL_NUMBERS = ("collisions-stale",)


def _causes(tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics without remarks on numbers that are told to be wrong: who corrects those is done.

    What is accepted hides nothing: it stays as it is.
    """
    wrong = [
        one
        for one in diagnostics
        if (one.severity == ERROR or one.rule == "length-looks-like-millimetres")
        and not accepted(tree, one, acceptable())
    ]
    refused = {one.span for one in wrong if one.severity == ERROR}
    said = refused.union(*map(_spans, wrong))

    def is_told(one: Diagnostic) -> bool:
        return one.severity != ERROR and (
            one.span in refused
            or (one.rule in _COMPARING and not said.isdisjoint(_spans(one)))
            or (one.rule in _OF_ALL_NUMBERS and bool(refused))
        )

    return [one for one in diagnostics if one.span is None or not is_told(one)]


def _spans(diagnostic: Diagnostic) -> set[Span | None]:
    return {diagnostic.span, *(related.span for related in diagnostic.related)} - {None}


def accepts(case: Case, found: Diagnostic) -> bool:
    """Return True if the description accepts a diagnostic."""
    return accepted(case.tree, found, acceptable())


def settled(case: Case, found: Iterable[Diagnostic], asked: str) -> list[Diagnostic]:
    """Return the diagnostics that are not accepted, and a warning for each entry that accepts nothing.

    ``asked`` is what the run asked for (``Rule.asked``).
    """
    left = without_accepted(case.tree, found, acceptable())
    return [*left.diagnostics, *unused(case.tree, left.used, acceptable(), (asked,))]
