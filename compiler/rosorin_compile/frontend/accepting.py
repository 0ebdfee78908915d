"""Accepting: what a rule refuses and a robot has all the same becomes a note (``accept`` of a description)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from ..diagnostics import MAX_LISTED, NOTE, WARNING, Diagnostic
from ..diagnostics.registry import OUTPUTS, Rule
from ..diagnostics.wording import and_more, first_of
from .tree import Map, Path, Seq, locate

RULES = (
    Rule(
        "accept-unused",
        "A warning: `accept` names a link or joint of which the rule says nothing.",
        "Remove the entry, or correct the name.",
        OUTPUTS,
    ),
)


# An entry of ``accept`` by its index, with a name in it; and all of them by rule and name.
_Entry = tuple[int, str]
_Wanted = dict[tuple[str, str], list[_Entry]]


def names_at(tree: Map, path: Path) -> tuple[str, ...]:
    """Return the names under which a problem at a path may be accepted: the link; the joint and its child."""
    section, name = (*path, "", "")[:2]
    entry: Any = tree.get(str(section))
    entry = entry.get(name) if isinstance(entry, dict) else None
    if section == "links":
        return (str(name),)
    if section == "poses":
        return tuple(str(step) for step in path[3:4])
    if not isinstance(entry, dict):
        return ()
    if section == "joints":
        return (str(name), str(entry.get("child")))
    if section != "sensors":
        return ()
    inner: Any = entry.get("optical") if path[2:3] == ("optical",) else entry
    frame = inner.get("frame") if isinstance(inner, dict) else None
    return () if frame is None else (str(inner.get("joint", f"{frame}_joint")), str(frame))


def accepted(tree: Map, diagnostic: Diagnostic) -> bool:
    """Say whether a description accepts what a diagnostic is about."""
    return bool(_entries(_wanted(tree), diagnostic))


def unknown(tree: Map, acceptable: Mapping[str, Rule]) -> list[Diagnostic]:
    """Return what is wrong with the ids that ``accept`` names; the tree may be of any shape."""
    diagnostics = []
    entries = tree.get("accept")
    for index, entry in enumerate(entries if isinstance(entries, Seq) else ()):
        rule = entry.get("rule") if isinstance(entry, Map) else None
        if isinstance(rule, str) and rule not in acceptable:
            from .complaint import not_allowed

            diagnostics.append(not_allowed(tree, ["accept", index, "rule"], rule, list(acceptable)))
    return diagnostics


def settled(
    tree: Map, diagnostics: Iterable[Diagnostic], acceptable: Mapping[str, Rule], complete: bool = True
) -> list[Diagnostic]:
    """Return the diagnostics, those that are accepted as one note for each rule.

    ``acceptable`` are the rules that may be accepted, by id. ``complete``: all rules were asked, so that what is
    accepted in vain is told too.
    """
    wanted = _wanted(tree)
    settled: list[Diagnostic] = []
    groups: dict[str, list[Diagnostic]] = {}
    used: set[_Entry] = set()
    for diagnostic in diagnostics:
        entries = _entries(wanted, diagnostic)
        used.update(entries)
        if entries:
            groups.setdefault(diagnostic.rule, []).append(diagnostic)
        else:
            settled.append(diagnostic)
    notes = [_note(tree, wanted, group) for group in groups.values()]
    return [*settled, *notes, *(_unused(tree, used, acceptable) if complete else ())]


def _wanted(tree: Map) -> _Wanted:
    """Return the entries of ``accept`` by rule and name."""
    wanted: _Wanted = {}
    for index, entry in enumerate(tree.get("accept") or ()):
        for name in entry["of"]:
            wanted.setdefault((entry["rule"], name), []).append((index, name))
    return wanted


def _entries(wanted: _Wanted, diagnostic: Diagnostic) -> list[_Entry]:
    """Return the entries of ``accept`` that a diagnostic falls under, with the name that they give it."""
    return [entry for name in diagnostic.of for entry in wanted.get((diagnostic.rule, name), ())]


def _note(tree: Map, wanted: _Wanted, group: list[Diagnostic]) -> Diagnostic:
    """Return the note for what is accepted of one rule."""
    reasons = dict.fromkeys(tree["accept"][index]["reason"] for d in group for index, _ in _entries(wanted, d))
    more = f",{and_more(len(group) - 1, 'of this kind')}" if len(group) > 1 else ""
    message = f"accepted: {group[0].message}{more} ({'; '.join(reasons)})"
    return group[0]._replace(severity=NOTE, message=message, help="", related=())


def _unused(tree: Map, used: set[_Entry], acceptable: Mapping[str, Rule]) -> list[Diagnostic]:
    """Return a warning for each entry of ``accept`` that names something of which the rule says nothing."""
    unused = []
    for index, entry in enumerate(tree.get("accept") or ()):
        idle = [name for name in dict.fromkeys(entry["of"]) if (index, name) not in used]
        if not idle:
            continue
        names, rule = first_of([f'"{name}"' for name in idle], MAX_LISTED), entry["rule"]
        message = f"{rule} is accepted of {names}, but says nothing of {'it' if len(idle) == 1 else 'them'}"
        place = locate(tree, ("accept", index, "of", list(entry["of"]).index(idle[0])))
        help = f"remove the entry, or name a {acceptable[rule].accept} that the rule refuses"
        unused.append(Diagnostic("accept-unused", WARNING, message, place.span, place.stack(), help))
    return unused
