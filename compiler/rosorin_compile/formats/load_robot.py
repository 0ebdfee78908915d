"""Load a robot: a description or a file in another format, expanded, validated, lowered to the model, and checked."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.language.accepting import Entry, settled, unknown
from rosorin_compile.language.expand import Expanded, expand
from rosorin_compile.language.expression.functions import plugged as plugged_functions
from rosorin_compile.language.lower import Lowered, lower
from rosorin_compile.language.section_registry import plugged as plugged_sections
from rosorin_compile.language.validate import validate
from rosorin_compile.language.wanted import with_wanted
from rosorin_compile.model import Robot
from rosorin_compile.rules import check as rules
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, has_errors
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.plugins import PluginFailed
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Map

from . import FORMATS, plugged_diagnostics
from .described import as_tree
from .imported import Imported, ReadOptions
from .reading import outputs_of, read_robot

if TYPE_CHECKING:
    from rosorin_compile.language.expand.included_robots import Tell
    from rosorin_compile.rules.case import Case


class Understood(NamedTuple):
    """A loaded robot: its tree and its model, each as far as it has no errors, and all diagnostics.

    ``used`` are the entries of ``accept`` that had an effect. ``imported`` is set for a robot in another format.
    """

    expanded: Expanded
    lowered: Lowered | None
    diagnostics: list[Diagnostic]
    used: frozenset[Entry] = frozenset()
    imported: Imported | None = None

    @property
    def robot(self) -> Robot | None:
        """The robot, or None with errors."""
        return None if self.lowered is None or has_errors(self.diagnostics) else self.lowered.robot

    @property
    def case(self) -> Case | None:
        """The robot with the positions of all its values, or None with errors."""
        from rosorin_compile.rules.case import Case
        from rosorin_compile.rules.magnitudes import collect

        robot, tree, lowered = self.robot, self.expanded.tree, self.lowered
        if robot is None or tree is None or lowered is None:
            return None
        return Case(robot, tree, lowered.places, collect(tree))


class RobotReader:
    """Reads the robots in other formats that descriptions include."""

    def endings(self) -> tuple[str, ...]:
        """Return the endings of the files in other formats that a description may include."""
        return FORMATS.endings(include=True)

    def read(
        self, path: Path, texts: Mapping[str, str], packages: Mapping[str, Path], lenient: bool, tell: Tell, by: Span
    ) -> Imported:
        """Read the robot of a file; ``by`` is the position of its name in the description."""
        imported = read_robot(path, ReadOptions(texts, packages, lenient, tell=tell), by)
        # The rules report notes that can be accepted again, for the whole robot.
        new = [one for one in imported.diagnostics if one.severity != NOTE or one.rule not in rules.acceptable()]
        return imported._replace(diagnostics=new)


def understand(
    path: Path,
    arguments: Mapping[str, Any] | None = None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    requested: Sequence[str] = (),
    cache: dict[Any, Any] | None = None,
) -> Understood:
    """Load the description whose main file is ``path``; no artifact is generated.

    ``tell`` receives warnings before code is executed; without it they are among the diagnostics. ``packages`` are
    folders of ROS packages by name. ``requested`` as in ``judge``; ``cache`` keeps parsed files.
    """
    return judge(expand(path, arguments or {}, RobotReader(), tell, packages, cache), requested)


def judge(expanded: Expanded, requested: Sequence[str] = ()) -> Understood:
    """Validate and lower an expanded tree, and check the rules.

    ``requested`` are outputs: names under ``outputs``, or of formats, which get their default options.
    """
    plugged = (*plugged_functions().diagnostics, *plugged_diagnostics(), *plugged_sections().diagnostics)
    if expanded.tree is None:
        return Understood(expanded, None, arrange([*expanded.diagnostics, *plugged, *rules.plugged().diagnostics]))
    tree, unknown_outputs = with_wanted(expanded.tree, requested, FORMATS)
    expanded = expanded._replace(tree=tree)
    diagnostics = [*expanded.diagnostics, *plugged, *unknown_outputs]
    Progress.step("validating")
    diagnostics += validate(tree, FORMATS, expanded.scope)
    Progress.step("building the robot")
    lowered = None if has_errors(diagnostics) else lower(tree, expanded.scope)
    diagnostics += [*rules.plugged().diagnostics, *unknown(tree, rules.acceptable())]
    if lowered is None or has_errors(diagnostics):
        return Understood(expanded, None, arrange(diagnostics))
    diagnostics += lowered.diagnostics
    if lowered.robot is not None:
        try:
            diagnostics += rules.check(lowered.robot, tree, lowered.places, FORMATS, expanded.scope, requested)
        except PluginFailed as problem:
            diagnostics.append(problem.diagnostic)
    if has_errors(diagnostics):
        from rosorin_compile.rules.misspelt import once

        diagnostics = once(diagnostics, tree, lowered.places)
    else:  # with errors, the use of an argument may be among what is wrong
        diagnostics += expanded.unused
    found = settled(tree, diagnostics, rules.acceptable())
    diagnostics = found.diagnostics
    if expanded.scope and expanded.scope.expansion.disabled and any(one.severity != NOTE for one in diagnostics):
        from rosorin_compile.language.expand.dropped_entries import explain_missing_names

        diagnostics = explain_missing_names(expanded.scope, tree, diagnostics)
    return Understood(expanded, lowered, arrange(diagnostics), found.used)


def understand_foreign(path: Path, options: ReadOptions) -> Understood:
    """Load a robot in another format, with its published output only; no rule is checked."""
    imported = read_robot(path, options)
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [FORMATS.published().name])
    expanded = Expanded(tree, imported.diagnostics, imported.files)
    if tree is None or has_errors(imported.diagnostics):
        return Understood(expanded, None, arrange(imported.diagnostics), imported=imported)
    lowered = lower(tree)
    diagnostics = arrange([*imported.diagnostics, *lowered.diagnostics])
    return Understood(expanded, lowered, diagnostics, imported=imported)


def judge_foreign(
    path: Path, options: ReadOptions, requested: Sequence[str] = (), optional: bool = False
) -> Understood:
    """Load a robot in another format as the description that ``import`` would write, and check the rules.

    Its outputs are those of that description, those of ``optional`` formats, and the ``requested`` ones.
    """
    imported = read_robot(path, options)
    names = [format.name for format in FORMATS.values() if optional or not format.optional]
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [*names, *requested])
    return judge(Expanded(tree, imported.diagnostics, imported.files), requested)


def _with_outputs(imported: Imported, tree: Map, names: Collection[str]) -> Map:
    """Return the tree with those outputs of its description that have one of the names."""
    made = tree.copied()
    outputs = Map(tree.span)
    for name, entry in outputs_of(imported).entries.items():
        if name in names:
            outputs.put(name, as_tree(entry, tree.span, ["outputs", name]), tree.span, tree.span)
    made.pop("outputs", None)
    made.put("outputs", outputs, tree.span, tree.span)
    return made
