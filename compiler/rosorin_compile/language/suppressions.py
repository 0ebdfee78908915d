"""Apply the key ``accept`` of a description: accepted errors become notes, accepted warnings and notes are removed."""

from collections.abc import Collection, Iterable, Mapping, Set
from contextlib import suppress
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Help, Suggestion, diagnostic, error
from rosorin_compile.source.rule_registry import OF_PLUGINS, PHYSICS, SIMULATION, Rule, find
from rosorin_compile.source.tree import Map, Path, Seq, has
from rosorin_compile.source.wording import MAX_LISTED, and_more, quote

from .annotations import Node, texts
from .schema import sections
from .symbols import THINGS, SymbolTable
from .validate import not_allowed

# Rules that ``accept`` cannot suppress, with the reason.
STAYS = {"stand-in": "a stand-in is reported until its value is measured", "accept-unused": "it is about accept itself"}

Entry = tuple[int, str]  # (index of an entry in the list ``accept``, name in its key ``of`` or EVERYTHING)
Rules = Mapping[str, Rule]  # the rules that descriptions may suppress, by id
_Entries = dict[tuple[str, str], list[Entry]]  # entries by rule id and name
EVERYTHING = ""  # the name in an entry without ``of``: it applies to the entire robot


class AcceptResult(NamedTuple):
    """The remaining diagnostics, and the entries of ``accept`` that suppressed a diagnostic."""

    diagnostics: list[Diagnostic]
    used: frozenset[Entry]


def names_at(tree: Map, path: Path) -> tuple[str, ...]:
    """Return the names by which ``accept`` may refer to an error at a path, such as a joint and its child link."""
    found: tuple[str, ...] = ()
    node, is_final = Node(properties=sections()), False
    value: Any = tree
    for step in path:
        if not is_final and node.keys is not None and node.keys.names:
            found = (str(step),)
        below = node.items if isinstance(step, int) else node.value_of(step)
        if below is None:
            return found
        node, value = below, value[step] if has(value, step) else None
        if node.accepted and isinstance(value, Map):
            known = {**{key: name for key, _, name in node.left_out(value)}, **texts(value)}
            found, is_final = (), True
            for name in node.accepted:
                with suppress(KeyError):  # the entry has no name of this kind
                    found += (name.format(*path, **known),)
    return (value,) if not is_final and node.names and isinstance(value, str) else found


def is_accepted(tree: Map, diagnostic: Diagnostic, acceptable: Rules) -> bool:
    """Return True if an entry of ``accept`` in the description suppresses the diagnostic."""
    return bool(_covering(_entries(tree), diagnostic, acceptable))


def unknown_rules(tree: Map, acceptable: Rules) -> list[Diagnostic]:
    """Return an error for each rule in ``accept`` that is unknown or cannot be suppressed; the tree may be invalid."""
    diagnostics, entries = [], tree.get("accept")
    for index, entry in enumerate(entries if isinstance(entries, Seq) else ()):
        rule = entry.get("rule") if isinstance(entry, Map) else None
        if not isinstance(rule, str) or rule in acceptable:
            continue
        known = OF_PLUGINS.get(rule) or find([rule]).get(rule)
        if known is None:
            diagnostics.append(not_allowed(tree, ["accept", index, "rule"], rule, list(acceptable)))
        elif rule in STAYS or not known.mild:
            why = STAYS.get(rule, "the robot could not be built, or would be wrong")
            span, message = tree.locate(("accept", index, "rule")).span, f'"accept" cannot suppress {rule}: {why}'
            diagnostics.append(error("accept-refused", message, span, 'remove this entry of "accept"'))
    return diagnostics


def apply(tree: Map, diagnostics: Iterable[Diagnostic], acceptable: Rules) -> AcceptResult:
    """Remove the warnings and notes that ``accept`` suppresses, and merge suppressed errors into one note per rule."""
    entries = _entries(tree)
    left: list[Diagnostic] = []
    groups: dict[str, list[Diagnostic]] = {}
    used: set[Entry] = set()
    for found in diagnostics:
        covering, is_error = _covering(entries, found, acceptable), found.severity == ERROR
        used.update(covering)
        if covering:
            if is_error:
                groups.setdefault(found.rule, []).append(found)
        elif is_error and found.rule in acceptable and (found.rule, EVERYTHING) in entries and found.of:
            help = (found.with_help().help, f'to suppress this error, add "of: [{found.of[0]}]"')
            left.append(replace(found.with_help(), help="; ".join(filter(None, help))))
        else:
            left.append(found)
    for group in groups.values():
        covering = [entry for one in group for entry in _covering(entries, one, acceptable)]
        reasons = dict.fromkeys(tree["accept"][index]["reason"] for index, _ in covering)
        more = f",{and_more(len(group) - 1, 'of this kind')}" if len(group) > 1 else ""
        message = f"accepted: {group[0].message}{more} (reason: {'; '.join(reasons)})"
        left.append(replace(group[0], severity=NOTE, message=message, help="", suggest=None, related=()))
    return AcceptResult(left, frozenset(used))


def _entries(tree: Map) -> _Entries:
    entries: _Entries = {}
    for index, entry in enumerate(tree.get("accept") or ()):
        for name in entry.get("of", (EVERYTHING,)):
            entries.setdefault((entry["rule"], name), []).append((index, name))
    return entries


def _covering(entries: _Entries, diagnostic: Diagnostic, acceptable: Rules) -> list[Entry]:
    rule = diagnostic.rule
    if diagnostic.severity == ERROR and rule not in acceptable:
        return []
    names = diagnostic.of if diagnostic.severity == ERROR else (*diagnostic.of, EVERYTHING)
    return [entry for name in names for entry in entries.get((rule, name), ())]


def unused_entries(tree: Map, used: Set[Entry], acceptable: Rules, asked: Collection[str] = ("",)) -> list[Diagnostic]:
    """Return a warning for each entry of ``accept`` that no diagnostic matches.

    ``asked`` has the checks of this run: "" (always), "meshes", "physics", "simulation"; skip rules of other checks.
    """
    diagnostics = []
    for index, entry in enumerate(tree.get("accept") or ()):
        idle = [name for name in dict.fromkeys(entry.get("of", (EVERYTHING,))) if (index, name) not in used]
        rule = entry["rule"]
        known = acceptable.get(rule) or OF_PLUGINS.get(rule) or find([rule]).get(rule)
        needed = {PHYSICS: "physics", SIMULATION: "simulation"}.get(known.topic, known.asked) if known else ""
        if not idle or needed not in asked:
            continue
        place = tree.locate(("accept", index, "rule"))
        message = f'"accept" has no effect: {rule} reports nothing'
        help: Help = 'remove this entry of "accept"'
        if "of" in entry:
            place = tree.locate(("accept", index, "of", list(entry["of"]).index(idle[0])))
            message += f" about {quote(idle, MAX_LISTED)}"
            names = SymbolTable(tree).names_of_kinds(THINGS)
            help = help if idle[0] in names else Suggestion(idle[0], names, instead=str(help))
        diagnostics.append(diagnostic("accept-unused", WARNING, message, place.span, help, place.stack()))
    return diagnostics
