"""Run the rules over a robot."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.language.expand.provenance import USED
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.lower.links import RULES as LINK_RULES
from rosorin_compile.language.lower.sections import is_resolved
from rosorin_compile.language.schema import plugged as plugged_sections
from rosorin_compile.language.suppressions import accepted, unused
from rosorin_compile.language.suppressions import settled as without_accepted
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
    containment,
    drive,
    frames,
    joints,
    kinematics,
    magnitudes,
    names,
    outputs,
    positions,
    publishers,
    shapes,
    simulated,
    tf_tree,
    urdf_elements,
)
from .case import Case

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

# The modules whose checks run, in this order; then those of sections for ROS and MuJoCo.
_MODULES = (
    *(kinematics, frames, joints, positions, drive, bodies, containment, shapes, publishers, tf_tree, outputs),
    *(magnitudes, urdf_elements, simulated, names),
)
_ACCEPT, _IMPORTED = ("", "link", "joint", "link or joint"), ("", "always", "lenient")
# Rules that compare a number with another, such as a size or a limit.
_COMPARING = (
    *("centre-outside", "collision-elsewhere", "inertia-implausible", "mass-implausible"),
    *("mimic-beyond-limit", "pose-beyond-limit", "size-implausible"),
)
# Rules about all numbers of a robot together: one wrong number is reason enough.
_OF_ALL_NUMBERS = ("collisions-stale",)


@cache
def checks() -> tuple[Check, ...]:
    """Return the checks of the tool itself, in the order in which they run."""
    own = (check for module in _MODULES for check in checks_of(module))
    return (*own, *(check for section in own_sections() for check in section.checks))


class Plugged(NamedTuple):
    """The checks that plug-ins add, and the diagnostics of invalid plug-ins."""

    checks: tuple[tuple[Plugin, Check], ...]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugged() -> Plugged:
    """Return the checks of plug-ins, and diagnostics of their invalid rules, those of sections included."""
    loaded, diagnostics = load("rules", Check, _ids, lambda id: bool(find([id])))
    refused = []
    for plugin, check in _section_checks():
        try:
            _ids(check)
        except (TypeError, ValueError) as problem:
            refused.append(broken(plugin, f"has a check that is none: {problem}"))
    OF_PLUGINS.update((rule.id, rule) for _, check in loaded for rule in check.rules)
    return Plugged(loaded, (*diagnostics, *refused))


def _section_checks() -> list[tuple[Plugin, Check]]:
    return [(plugin, check) for plugin, section in plugged_sections().sections for check in section.checks]


def _ids(check: Check) -> list[str]:
    """Return the ids of a plug-in's check. Raises TypeError or ValueError if its rules are invalid."""
    for rule in check.rules:
        check_texts(rule)
        if not is_id(rule.id):
            raise ValueError(f'"{rule.id}" is no id of a rule: small letters, digits and single hyphens')
        if rule.accept not in _ACCEPT or rule.imported not in _IMPORTED:
            raise ValueError(f"accept of {rule.id} is one of {_ACCEPT}, imported one of {_IMPORTED}")
    if not check.rules:
        raise ValueError("it declares no rule; put @rule above the function")
    return [rule.id for rule in check.rules]


def is_id(text: str) -> bool:
    """Return True if a text has the form of an id: kebab-case."""
    return all(word.isascii() and word.isalnum() and word == word.lower() for word in text.split("-"))


@cache
def acceptable() -> Mapping[str, Rule]:
    """Return the rules that a description may accept, by id; all else cannot be built, or would be built wrongly."""
    all_checks = (*checks(), *(check for _, check in (*plugged().checks, *_section_checks())))
    rules = (*LINK_RULES, *(rule for check in all_checks for rule in check.rules))
    return {rule.id: rule for rule in sorted(rules, key=lambda rule: rule.id) if rule.accept}


def check(
    robot: Robot,
    tree: Map,
    places: Mapping[tuple[str, str], TreePath],
    formats: Mapping[str, Format],
    scope: Scope | None = None,
    wanted: Collection[str] = (),
) -> list[Diagnostic]:
    """Check a robot against all rules and return the diagnostics.

    ``places`` leads from a joint or a link, by kind and name, to its path in the tree (see ``lower``); ``formats`` are
    those that outputs may name, ``scope`` has the names of expressions, ``wanted`` as in ``Case``.
    """
    case = Case(robot, tree, places, magnitudes.collect(tree), formats, scope, wanted)
    diagnostics: list[Diagnostic] = []
    for number, one in enumerate(checks()):
        Progress.step("checking", number, len(checks()))
        diagnostics += one(case)
    others = list(plugged().checks)
    for plugin, section in plugged_sections().sections:
        if section in robot.sections and is_resolved(robot, case.symbols, section.name):
            others += [(plugin, one) for one in section.checks]
    for plugin, one in others:
        diagnostics += _guarded(plugin, one, case)
    return _causes(tree, _joined(tree, diagnostics))


def _guarded(plugin: Plugin, check: Check, case: Case) -> list[Diagnostic]:
    """Return the diagnostics of a plug-in's check until it does something wrong, and an error about that."""
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
    """Merge the diagnostics of one rule at one value that is used many times; accepted ones stay apart, by name."""
    found: dict[object, Diagnostic] = {}
    for diagnostic in diagnostics:
        uses = [related for related in diagnostic.related if related.message == USED]
        is_alone = not uses or accepted(tree, diagnostic, acceptable())
        key: object = (len(found), diagnostic) if is_alone else (diagnostic.rule, diagnostic.span)
        first = found.setdefault(key, diagnostic)
        if first is not diagnostic:
            last = max(index for index, related in enumerate(first.related) if related.message == USED) + 1
            more = [use for use in uses if use not in first.related]
            found[key] = replace(first, related=(*first.related[:last], *more, *first.related[last:]))
    return list(found.values())


def _causes(tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Drop warnings and notes that follow from numbers with an error; an accepted diagnostic hides nothing."""
    wrong = [
        one
        for one in diagnostics
        if (one.severity == ERROR or one.rule == "length-looks-like-millimetres")
        and not accepted(tree, one, acceptable())
    ]
    refused = {one.span for one in wrong if one.severity == ERROR}
    places = refused.union(*map(_spans, wrong))

    def follows(one: Diagnostic) -> bool:
        if one.severity == ERROR or one.span is None:
            return False
        is_compared = one.rule in _COMPARING and not places.isdisjoint(_spans(one))
        return is_compared or one.span in refused or (one.rule in _OF_ALL_NUMBERS and bool(refused))

    return [one for one in diagnostics if not follows(one)]


def _spans(diagnostic: Diagnostic) -> set[Span | None]:
    return {diagnostic.span, *(related.span for related in diagnostic.related)} - {None}


def accepts(case: Case, found: Diagnostic) -> bool:
    """Return True if the description accepts a diagnostic."""
    return accepted(case.tree, found, acceptable())


def settled(case: Case, found: Iterable[Diagnostic], asked: str) -> list[Diagnostic]:
    """Return the diagnostics that are not accepted, and a warning for each unused entry of ``accept``.

    ``asked`` is the kind of rules that the run checks (``Rule.asked``).
    """
    left = without_accepted(case.tree, found, acceptable())
    return [*left.diagnostics, *unused(case.tree, left.used, acceptable(), (asked,))]
