"""Run the rules on a robot, and merge diagnostics that have the same cause."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.expand.provenance import USED
from rosorin_compile.language.expand.scope import Scope
from rosorin_compile.language.lower import unresolved_references
from rosorin_compile.language.schema import plugin_sections as plugged_sections
from rosorin_compile.language.suppressions import apply as without_accepted
from rosorin_compile.language.suppressions import is_accepted, unused_entries
from rosorin_compile.language.symbols import SymbolTable
from rosorin_compile.model import Robot
from rosorin_compile.model.sections import own_sections
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Related, Span
from rosorin_compile.source.messages import UNNAMED, Offer, merge_by_name, move_to_name, offer, place_of_word
from rosorin_compile.source.plugins import Plugin, broken_plugin, diagnostic_of, divert_stdout, failed_plugin, load
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import OF_PLUGINS, Check, Rule, checks_of, find, find_declared
from rosorin_compile.source.tree import Map, Place, Seq, nearer
from rosorin_compile.source.tree import Path as TreePath

from .case import Case
from .magnitudes import collect

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

# Modules with checks of the entire robot. Each ``Section`` lists the checks of its section.
_MODULES = ("frames", "magnitudes", "names")
# Rules that compare two numbers: their warnings are dropped if one of the numbers has an error.
_COMPARING = (
    *("centre-outside", "collision-elsewhere", "inertia-implausible", "mass-implausible"),
    *("mimic-beyond-limit", "pose-beyond-limit", "size-implausible"),
)
# Maps rules to possible causes: a rule is not reported if there is an error of a rule that it is mapped to.
_FOLLOWING = {
    "control-joint": ("unknown-link", "unknown-joint", "unknown-option"),
    "control-mimic": ("mimic-unknown",),
    "controller-interface": ("control-interface", "unknown-joint"),
    "controller-missing": ("control-interface", "controller-name", "unknown-joint"),
    "moveit-not-in-urdf": ("unknown-backend", "unknown-option"),
    "moveit-state": ("unknown-joint",),
    **dict.fromkeys(("moveit-urdf", "scene-without-robot"), ("unknown-backend",)),
    **dict.fromkeys(("navigation-frames", "navigation-owner"), ("unknown-link", "unknown-publisher")),
    "unreached-link": ("unknown-link",),
}


@cache
def checks() -> tuple[Check, ...]:
    """Return the built-in checks in the order in which they run."""
    of_sections = [check for section in own_sections() for check in section.all_checks()]
    modules = [import_module(f"{__package__}.{name}") for name in _MODULES]
    return (*of_sections, *(check for module in modules for check in checks_of(module)))


@cache
def plugin_checks() -> tuple[tuple[tuple[Plugin, Check], ...], tuple[Diagnostic, ...]]:
    """Return (plug-in, check) for each plug-in check that belongs to no section, and errors about plug-ins."""
    loaded, diagnostics = load("rules", Check, Check.ids, lambda id: bool(find([id])))
    OF_PLUGINS.update((rule.id, rule) for _, check in loaded for rule in check.rules)
    return loaded, diagnostics


@cache
def acceptable() -> Mapping[str, Rule]:
    """Return the rules, by id, that ``accept`` can suppress. Breaking any other rule makes artifacts incorrect."""
    of_sections = [check for _, section in plugged_sections().sections for check in section.all_checks()]
    all_checks = (*checks(), *of_sections, *(check for _, check in plugin_checks()[0]))
    rules = (find_declared("shape-size"), *(rule for check in all_checks for rule in check.rules))
    return {rule.id: rule for rule in sorted(rules, key=lambda rule: rule.id) if rule.accept}


def check(
    robot: Robot,
    tree: Map,
    places: Mapping[tuple[str, str], TreePath],
    formats: "Mapping[str, Format]",
    scope: Scope | None = None,
    wanted: Collection[str] = (),
) -> list[Diagnostic]:
    """Check a robot against all rules and return the diagnostics.

    ``places`` maps (kind, name) to paths in the tree. For ``formats``, ``scope`` and ``wanted`` see ``Case``.
    """
    case = Case(robot, tree, places, collect(tree), formats, scope, wanted)
    found: list[Diagnostic] = []
    for number, examine in enumerate(checks()):
        Progress.step("checking", number, len(checks()))
        found += examine(case)
    added = list(plugin_checks()[0])
    for plugin, section in plugged_sections().sections:
        if section in robot.sections and not unresolved_references(robot, case.symbols, section.name):
            added += [(plugin, examine) for examine in section.all_checks()]
    for plugin, examine in added:
        found += _of_plugin(plugin, examine, case)
    return _without_consequences(tree, _merge_uses(tree, found))


def _of_plugin(plugin: Plugin, check: Check, case: Case) -> Iterator[Diagnostic]:
    ids = [rule.id for rule in check.rules]
    try:
        with divert_stdout():
            for diagnostic in check(case):
                if not isinstance(diagnostic, Diagnostic) or diagnostic.rule not in ids:
                    what = f"yields {str(diagnostic)[:80]}, no Diagnostic of its rules ({', '.join(ids)})"
                    yield broken_plugin(plugin, what)
                    return
                yield diagnostic_of(diagnostic)
    except (Exception, SystemExit) as problem:
        yield failed_plugin(plugin, problem)


def _merge_uses(tree: Map, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Merge diagnostics about the same value of a part that is used several times, unless suppressed by ``accept``."""
    found: dict[object, Diagnostic] = {}
    for diagnostic in diagnostics:
        uses = [related for related in diagnostic.related if related.message == USED]
        is_alone = not uses or is_accepted(tree, diagnostic, acceptable())
        key: object = (len(found), diagnostic) if is_alone else (diagnostic.rule, diagnostic.span)
        first = found.setdefault(key, diagnostic)
        if first is not diagnostic:
            last = max(index for index, related in enumerate(first.related) if related.message == USED) + 1
            more = [use for use in uses if use not in first.related]
            found[key] = replace(first, related=(*first.related[:last], *more, *first.related[last:]))
    return list(found.values())


def _without_consequences(tree: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Drop warnings and notes about numbers that also have an error, unless ``accept`` suppresses the error."""
    causes = [one for one in diagnostics if one.severity == ERROR or one.rule == "length-looks-like-millimetres"]
    causes = [one for one in causes if not is_accepted(tree, one, acceptable())]
    refused = {one.span for one in causes if one.severity == ERROR}
    places = refused.union(*({one.span, *(related.span for related in one.related)} for one in causes)) - {None}

    def follows(one: Diagnostic) -> bool:
        if one.severity == ERROR or one.span is None:
            return False
        is_compared = one.rule in _COMPARING and not places.isdisjoint((one.span, *(two.span for two in one.related)))
        # Collisions depend on all numbers of the robot, so a wrong number can invalidate the recorded collision pairs.
        return is_compared or one.span in refused or (one.rule == "collisions-stale" and bool(refused))

    return [one for one in diagnostics if not follows(one)]


def apply_acceptances(case: Case, found: Iterable[Diagnostic], asked: str) -> list[Diagnostic]:
    """Apply ``accept`` to the diagnostics of an optional check (see ``Rule.asked``), and warn of unused entries."""
    left = without_accepted(case.tree, found, acceptable())
    return [*left.diagnostics, *unused_entries(case.tree, left.used, acceptable(), (asked,))]


def merge_misspelt(diagnostics: list[Diagnostic], tree: Map) -> list[Diagnostic]:
    """Merge all diagnostics caused by one misspelt name.

    A misspelt name is reported once, where it is written. If no reference is spelt like the definition, the definition
    may be misspelt, so the diagnostic also shows it.
    """
    wrong = {one.rule for one in diagnostics if one.severity == ERROR}
    diagnostics = [one for one in diagnostics if wrong.isdisjoint(_FOLLOWING.get(one.rule, ()))]
    offers = [offer(one) for one in diagnostics]
    uses: dict[str, list[tuple[TreePath, Place]]] = {one.meant: [] for one in offers if one}
    if not uses:
        return diagnostics
    _collect_uses(tree, tree.via, (), uses)
    defined = {one.name: one for one in reversed([*SymbolTable(tree).definitions()])}
    moved = []
    for diagnostic, found in zip(diagnostics, offers, strict=True):
        moved.append(move_to_name(diagnostic, found))
        definition = defined.get(found.meant) if found else None
        if found and definition:
            path = definition.path
            home = _home(tree.locate(path, key=definition.key), found)
            if all(_home(use, found) == home for where, use in uses[found.meant] if where[: len(path)] != path):
                note = Related(f'"{found.meant}" {UNNAMED}', home)
                moved[-1] = replace(moved[-1], related=(*moved[-1].related, note))
    homes = {note.span for one in moved for note in one.related if note.message.endswith(UNNAMED)}
    # Drop warnings about swapped letters in these unused definitions, because they are the same problem.
    return merge_by_name(one for one in moved if one.severity == ERROR or one.span not in homes)


def _home(place: Place, found: Offer) -> Span:
    return place_of_word([place.span, *(one.span for one in place.stack())], found.meant, found.name) or place.span


def _collect_uses(node: Any, via: Any, path: TreePath, uses: dict[str, list[tuple[TreePath, Place]]]) -> None:
    via = nearer(via, node.via)
    for key, value in node.items() if isinstance(node, Map) else enumerate(node):
        if key in uses:
            uses[key].append(((*path, key), Place(node.key_spans[key], via)))
        if isinstance(value, (Map, Seq)):
            _collect_uses(value, via, (*path, key), uses)
        elif isinstance(value, str):
            for name in uses.keys() & (re.findall(r"\w+", value) if key == "when" else (value,)):  # an expression
                uses[name].append(((*path, key), Place(node.value_spans[key], via)))
