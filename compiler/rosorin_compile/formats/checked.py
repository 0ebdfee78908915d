"""Checked: the tree of an imported robot, held against the rules, which some of it may break.

A robot that exists, with an axis of length 2 or a box without thickness, is read by the programs that have to read it:
such things are accepted by an entry of ``accept``, and said. What no reader can live with is an error.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from rosorin_compile.language.lower import lower
from rosorin_compile.language.lower.links import RULES
from rosorin_compile.language.suppressions import settled
from rosorin_compile.language.validate import validate
from rosorin_compile.model import Robot
from rosorin_compile.rules.check import acceptable, check
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, has_errors
from rosorin_compile.source.messages import gathered
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map, Seq

from . import FORMATS
from .imported import Imported

REASON = "the robot was imported with it"


def accept(tree: Map, lenient: bool) -> tuple[Map | None, list[Diagnostic]]:
    """Return the tree with an entry in ``accept`` for what it needs, and what there is to say.

    There is no tree if anything is wrong that cannot be accepted. ``lenient`` accepts more.
    """
    Progress.step("validating")
    wrong = [one for one in validate(tree, FORMATS) if one.severity == ERROR]
    if wrong:
        return None, wrong
    problems = _problems(tree)
    names: dict[str, dict[str, Diagnostic]] = {}
    for _ in range(3):  # what lowering refuses hides what the rules would say
        before = sum(map(len, names.values()))
        for diagnostic in problems:
            if _acceptable(tree, diagnostic, lenient):
                names.setdefault(diagnostic.rule, {}).setdefault(_name(diagnostic), diagnostic)
        if sum(map(len, names.values())) == before:
            break
        tree = _with_accept(tree, names)
        problems = _problems(tree)
    told = [_with_way_out(d, lenient) for d in settled(tree, problems, acceptable()).diagnostics if _is_told(d)]
    return (None if has_errors(told) else tree), gathered(told, [WARNING])


def _problems(tree: Map) -> list[Diagnostic]:
    """Return what lowering and the rules say of a tree that is to become what robot_state_publisher reads."""
    whole = tree.copied()
    if "outputs" not in whole:
        whole.put("outputs", _published(tree), tree.span, tree.span)
    lowered = lower(whole)
    diagnostics = list(lowered.diagnostics)
    if lowered.robot is not None:
        diagnostics += check(lowered.robot, whole, lowered.places, FORMATS)
    return diagnostics


def _published(tree: Map) -> Map:
    """Return outputs that hold nothing but what robot_state_publisher reads."""
    format = FORMATS.published()
    outputs, output = Map(tree.span), Map(tree.span)
    output.put("file", f"robot{format.endings[0]}", tree.span, tree.span)
    outputs.put(format.name, output, tree.span, tree.span)
    return outputs


def _acceptable(tree: Map, diagnostic: Diagnostic, lenient: bool) -> bool:
    rule = acceptable().get(diagnostic.rule)
    if rule is None or not diagnostic.of or diagnostic.severity != ERROR:
        return False
    if rule.imported == "always":
        return True
    if diagnostic.rule == "mass-not-positive":
        mass = tree["links"][_name(diagnostic)]["inertial"]["mass"]
        return lenient or mass == 0
    return lenient and rule.imported == "lenient"


def _name(diagnostic: Diagnostic) -> str:
    """Return the name that an entry of ``accept`` gives a diagnostic: the joint, or the link that is its child."""
    return diagnostic.of[-1] if acceptable()[diagnostic.rule].accept == "link" else diagnostic.of[0]


def _with_accept(tree: Map, names: dict[str, dict[str, Diagnostic]]) -> Map:
    """Return the tree with one entry of ``accept`` a rule."""
    made = tree.copied()
    entries = Seq(tree.span)
    for rule in sorted(names):
        first = next(iter(names[rule].values())).span or tree.span
        entry, of = Map(first), Seq(first)
        for name, diagnostic in names[rule].items():
            of.put(name, diagnostic.span or first)
        entry.put("rule", rule, first, first)
        entry.put("of", of, first, first)
        entry.put("reason", REASON, first, first)
        entries.put(entry, first)
    if entries:
        made.put("accept", entries, tree.span, tree.span)
    return made


def _is_told(diagnostic: Diagnostic) -> bool:
    """Say whether an import tells something: errors, and all that may be accepted; the rest is about descriptions."""
    return diagnostic.severity == ERROR or diagnostic.rule in acceptable()


def _with_way_out(diagnostic: Diagnostic, lenient: bool) -> Diagnostic:
    rule = acceptable().get(diagnostic.rule)
    if diagnostic.severity == ERROR and rule and rule.imported == "lenient" and diagnostic.of and not lenient:
        help = f"{diagnostic.help}; --lenient takes it as it is" if diagnostic.help else "--lenient takes it as it is"
        return replace(diagnostic, help=help)
    return diagnostic


def errors(imported: Imported, rules: bool = True) -> list[Diagnostic]:
    """Return the errors in the sections of a robot; if there are none, those of the ``rules``."""
    tree = imported.whole
    wrong = [one for one in validate(tree, FORMATS) if one.severity == ERROR]
    if wrong or not rules:
        return wrong
    lowered = imported.lowered()
    told = list(lowered.diagnostics)
    if lowered.robot is not None:
        told += check(lowered.robot, tree, lowered.places, FORMATS)
    return [one for one in told if one.severity == ERROR]


def lower_artifact(tree: Map, diagnostics: Iterable[Diagnostic]) -> Robot:
    """Return the robot of a tree that was read from an artifact of ours, with the diagnostics of the reading.

    Mistakes that a description may accept are in its artifacts as well. Raises ValueError for any other.
    """
    links = [*(tree.get("links") or ())]
    tree["accept"] = [{"rule": rule.id, "of": links, "reason": ""} for rule in RULES if rule.accept]
    _raise_unless_acceptable(diagnostics)
    if "robot" not in tree:
        raise ValueError("the robot has no name")
    lowered = lower(tree)
    _raise_unless_acceptable(lowered.diagnostics)
    if lowered.robot is None:
        raise ValueError("it contains no robot")
    return lowered.robot


def _raise_unless_acceptable(diagnostics: Iterable[Diagnostic]) -> None:
    for one in diagnostics:
        if one.severity == ERROR and one.rule not in acceptable():
            raise ValueError(one.message)
