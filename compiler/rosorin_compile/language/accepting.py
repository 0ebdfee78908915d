"""Accepting: what a rule says and a robot has all the same (``accept`` of a description).

What a rule refuses becomes a note; what is a warning or a note is not told any more: its reason stands in the file.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import ERROR, MAX_LISTED, NOTE, WARNING, Diagnostic
from rosorin_compile.source.diagnostics import error as problem
from rosorin_compile.source.rule_registry import OF_PLUGINS, OUTPUTS, PHYSICS, SIMULATION, Rule, find
from rosorin_compile.source.tree import Map, Path, Seq, locate
from rosorin_compile.source.wording import and_more, first_of

from .annotations import Node, texts
from .schema import sections

RULES = (
    Rule(
        "accept-unused",
        "A warning: `accept` names a rule that has nothing to say, or a link or joint of which it says nothing.",
        "Remove the entry, or correct the name.",
        OUTPUTS,
    ),
    Rule(
        "accept-refused",
        "`accept` names a rule whose errors cannot be accepted, or what stays until it is mended, such as stand-ins.",
        "Remove the entry.",
        OUTPUTS,
    ),
)

# What is told until it is mended, and why.
STAYS = {"stand-in": "a stand-in is told until its value is measured", "accept-unused": "it speaks of accept itself"}

# An entry of ``accept`` by its index, with a name in it, or without one for all that the rule says; and all of them by
# rule and name.
Entry = tuple[int, str]
_Wanted = dict[tuple[str, str], list[Entry]]
# It is also what a diagnostic is ``of`` that is about the robot as a whole.
EVERYTHING = ""


class Settled(NamedTuple):
    """The diagnostics that are left, and the entries of ``accept`` that took the others."""

    diagnostics: list[Diagnostic]
    used: frozenset[Entry]


def names_at(tree: Map, path: Path) -> tuple[str, ...]:
    """Return the names under which a problem at a path may be accepted: the link; the joint and its child.

    The innermost thing on the way of which the schema says so has them (``x-accepted``); else it is the name there.
    """
    found: tuple[str, ...] = ()
    node: Node = Node(properties=sections())
    value: Any = tree
    told = False
    for step in path:
        if not told and node.keys is not None and node.keys.names:
            found = (str(step),)
        below = node.below(step)
        if below is None:
            return found
        node, value = below, _inner(value, step)
        if node.accepted and isinstance(value, Map):
            found, told = tuple(_names(node, value, path)), True
    return (value,) if not told and node.names and isinstance(value, str) else found


def _inner(value: Any, step: str | int) -> Any:
    try:
        return value[step]
    except (KeyError, IndexError, TypeError):
        return None


def _names(node: Node, entry: Map, path: Path) -> Iterator[str]:
    said = {**{key: name for key, _, name in node.left_out(entry)}, **texts(entry)}
    for name in node.accepted:
        with suppress(KeyError):  # it has no such name
            yield name.format(*path, **said)


def accepted(tree: Map, diagnostic: Diagnostic, acceptable: Mapping[str, Rule]) -> bool:
    """Say whether a description accepts what a diagnostic is about."""
    return bool(_entries(_wanted(tree), diagnostic, acceptable))


def unknown(tree: Map, acceptable: Mapping[str, Rule]) -> list[Diagnostic]:
    """Return what is wrong with the ids that ``accept`` names; the tree may be of any shape."""
    diagnostics = []
    entries = tree.get("accept")
    for index, entry in enumerate(entries if isinstance(entries, Seq) else ()):
        rule = entry.get("rule") if isinstance(entry, Map) else None
        if not isinstance(rule, str) or rule in acceptable:
            continue
        known = OF_PLUGINS.get(rule) or find([rule]).get(rule)
        if known is None:
            from .validate import not_allowed

            diagnostics.append(not_allowed(tree, ["accept", index, "rule"], rule, list(acceptable)))
        elif rule in STAYS or not known.mild:
            why = STAYS.get(rule, "what it refuses cannot be built, or would be built wrongly")
            place = locate(tree, ("accept", index, "rule"))
            message = f"{rule} cannot be accepted: {why}"
            diagnostics.append(problem("accept-refused", message, place.span, "remove the entry"))
    return diagnostics


def settled(tree: Map, diagnostics: Iterable[Diagnostic], acceptable: Mapping[str, Rule]) -> Settled:
    """Return the diagnostics without warnings and notes that are accepted, and of errors that are one note a rule.

    ``acceptable`` are the rules whose errors may be accepted, by id.
    """
    wanted = _wanted(tree)
    left: list[Diagnostic] = []
    groups: dict[str, list[Diagnostic]] = {}
    used: set[Entry] = set()
    for diagnostic in diagnostics:
        entries = _entries(wanted, diagnostic, acceptable)
        used.update(entries)
        if not entries:
            left.append(_with_way_out(diagnostic, wanted, acceptable))
        elif diagnostic.severity == ERROR:
            groups.setdefault(diagnostic.rule, []).append(diagnostic)
    notes = [_note(tree, group, _wanted(tree), acceptable) for group in groups.values()]
    return Settled([*left, *notes], frozenset(used))


def _wanted(tree: Map) -> _Wanted:
    wanted: _Wanted = {}
    for index, entry in enumerate(tree.get("accept") or ()):
        for name in entry.get("of", (EVERYTHING,)):
            wanted.setdefault((entry["rule"], name), []).append((index, name))
    return wanted


def _entries(wanted: _Wanted, diagnostic: Diagnostic, acceptable: Mapping[str, Rule]) -> list[Entry]:
    """Return the entries of ``accept`` that cover a diagnostic. An error has to be named, others need not be."""
    rule = diagnostic.rule
    if diagnostic.severity == ERROR and rule not in acceptable:
        return []
    names = diagnostic.of if diagnostic.severity == ERROR else (*diagnostic.of, EVERYTHING)
    return [entry for name in names for entry in wanted.get((rule, name), ())]


def _with_way_out(diagnostic: Diagnostic, wanted: _Wanted, acceptable: Mapping[str, Rule]) -> Diagnostic:
    """Return an error whose rule is accepted without a name with the name that it takes."""
    if diagnostic.severity != ERROR or diagnostic.rule not in acceptable or (diagnostic.rule, EVERYTHING) not in wanted:
        return diagnostic
    help = f"an error is accepted by name: of: [{diagnostic.of[0]}]" if diagnostic.of else ""
    return replace(diagnostic, help="; ".join(filter(None, (diagnostic.help, help))))


def _note(tree: Map, group: list[Diagnostic], wanted: _Wanted, acceptable: Mapping[str, Rule]) -> Diagnostic:
    entries = [entry for d in group for entry in _entries(wanted, d, acceptable)]
    reasons = dict.fromkeys(tree["accept"][index]["reason"] for index, _ in entries)
    more = f",{and_more(len(group) - 1, 'of this kind')}" if len(group) > 1 else ""
    message = f"accepted: {group[0].message}{more} ({'; '.join(reasons)})"
    return replace(group[0], severity=NOTE, message=message, help="", related=())


def unused(
    tree: Map, used: Set[Entry], acceptable: Mapping[str, Rule], asked: Collection[str] = ("",)
) -> list[Diagnostic]:
    """Return a warning for each entry of ``accept`` that names something of which the rule says nothing.

    ``asked`` is what was asked for (``Rule.asked``): of what nobody asked for, nobody knows whether it is so.
    """
    diagnostics = []
    for index, entry in enumerate(tree.get("accept") or ()):
        idle = [name for name in dict.fromkeys(entry.get("of", (EVERYTHING,))) if (index, name) not in used]
        if not idle or _asked(entry["rule"], acceptable) not in asked:
            continue
        rule, place, help = entry["rule"], locate(tree, ("accept", index, "rule")), "remove the entry"
        message = f"{rule} is accepted, but has nothing to say"
        if "of" in entry:
            place = locate(tree, ("accept", index, "of", list(entry["of"]).index(idle[0])))
            quoted = first_of([f'"{name}"' for name in idle], MAX_LISTED)
            message = f"{rule} is accepted of {quoted}, but says nothing of {'it' if len(idle) == 1 else 'them'}"
            of = acceptable[rule].accept if rule in acceptable else "part"
            help = _meant(tree, idle[0]) or f"remove the entry, or name a {of} that the rule refuses"
        diagnostics.append(Diagnostic("accept-unused", WARNING, message, place.span, place.stack(), help))
    return diagnostics


def _meant(tree: Map, name: str) -> str:
    """Return 'did you mean "x"?' for what is nearly a name of the description; empty for one that is, or is far."""
    from rosorin_compile.source.diagnostics import did_you_mean

    from .symbols import THINGS, SymbolTable

    names = SymbolTable(tree).names().among(THINGS)
    guess = "" if name in names else did_you_mean(name, sorted(names))
    return guess if guess.startswith("did") else ""


def _asked(id: str, acceptable: Mapping[str, Rule]) -> str:
    rule = acceptable.get(id) or OF_PLUGINS.get(id) or find([id]).get(id)
    if rule is None or rule.topic == PHYSICS:
        return "physics" if rule else ""
    if rule.topic == SIMULATION:
        return "simulation"
    return rule.asked
