"""Accepting: the meaning of an imported tree, held against the rules.

A robot that exists, with an axis of length 2 or a box without thickness, is read by the programs that have to read it:
such things are accepted by an entry of ``accept``, and said. What no reader can live with is an error.
"""

from __future__ import annotations

from ..diagnostics import ERROR, NOTE, Diagnostic, has_errors
from ..frontend.accepting import settled
from ..frontend.lower import lower
from ..frontend.tree import Map, Seq
from ..frontend.validate import validate
from ..rules import acceptable, check
from . import FORMATS, published

REASON = "the robot was imported with it"


def accept(tree: Map, lenient: bool) -> tuple[Map | None, list[Diagnostic]]:
    """Return the tree with an entry in ``accept`` for what it needs, and what there is to say.

    There is no tree if anything is wrong that cannot be accepted. ``lenient`` accepts more.
    """
    wrong = [found for found in validate(tree, FORMATS) if found.severity == ERROR]
    if wrong:
        return None, wrong
    found = _found(tree)
    names: dict[str, dict[str, Diagnostic]] = {}
    for _ in range(3):  # what lowering refuses hides what the rules would say
        before = sum(map(len, names.values()))
        for diagnostic in found:
            if _acceptable(tree, diagnostic, lenient):
                names.setdefault(diagnostic.rule, {}).setdefault(_name(diagnostic), diagnostic)
        if sum(map(len, names.values())) == before:
            break
        tree = _with_accept(tree, names)
        found = _found(tree)
    said = [
        _with_way_out(d, lenient) for d in settled(tree, found, acceptable()) if d.severity == ERROR or _is_accepted(d)
    ]
    return (None if has_errors(said) else tree), said


def _found(tree: Map) -> list[Diagnostic]:
    """Return what lowering and the rules say of a tree that is to become what robot_state_publisher reads."""
    whole = _copied(tree)
    if "outputs" not in whole:
        whole.put("outputs", _published(tree), tree.span, tree.span)
    lowered = lower(whole)
    found = list(lowered.diagnostics)
    if lowered.robot is not None:
        found += check(lowered.robot, whole, lowered.places, FORMATS)
    return found


def _published(tree: Map) -> Map:
    """Return outputs that hold nothing but what robot_state_publisher reads."""
    format = published()
    outputs, output = Map(tree.span), Map(tree.span)
    output.put("file", f"robot{format.endings[0]}", tree.span, tree.span)
    outputs.put(format.name, output, tree.span, tree.span)
    return outputs


def _acceptable(tree: Map, found: Diagnostic, lenient: bool) -> bool:
    rule = acceptable().get(found.rule)
    if rule is None or not found.of:
        return False
    if rule.imported == "always":
        return True
    if found.rule == "mass-not-positive":
        mass = tree["links"][_name(found)]["inertial"]["mass"]
        return lenient or mass == 0
    return lenient and rule.imported == "lenient"


def _name(found: Diagnostic) -> str:
    """Return the name that an entry of ``accept`` gives a diagnostic: the joint, or the link that is its child."""
    return found.of[-1] if acceptable()[found.rule].accept == "link" else found.of[0]


def _copied(tree: Map) -> Map:
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    return made


def _with_accept(tree: Map, names: dict[str, dict[str, Diagnostic]]) -> Map:
    """Return the tree with one entry of ``accept`` a rule."""
    made = _copied(tree)
    entries = Seq(tree.span)
    for rule in sorted(names):
        first = next(iter(names[rule].values())).span or tree.span
        entry, of = Map(first), Seq(first)
        for name, found in names[rule].items():
            of.put(name, found.span or first)
        entry.put("rule", rule, first, first)
        entry.put("of", of, first, first)
        entry.put("reason", REASON, first, first)
        entries.put(entry, first)
    if entries:
        made.put("accept", entries, tree.span, tree.span)
    return made


def _is_accepted(found: Diagnostic) -> bool:
    return found.severity == NOTE and found.rule in acceptable()


def _with_way_out(found: Diagnostic, lenient: bool) -> Diagnostic:
    rule = acceptable().get(found.rule)
    if found.severity == ERROR and rule and rule.imported == "lenient" and found.of and not lenient:
        help = f"{found.help}; --lenient takes it as it is" if found.help else "--lenient takes it as it is"
        return found._replace(help=help)
    return found
