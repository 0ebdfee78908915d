"""Foreign robots in place of a description, for commands that only ask about one and write nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from ..diagnostics import Diagnostic, arrange, has_errors
from ..formats import Artifact, published
from ..formats.imported import Imported, ReadOptions
from ..formats.reading import read
from ..formats.templating import Templates
from ..frontend.expand import Expanded
from ..frontend.lower import lower
from ..frontend.tree import Map
from ..pipeline import Compiled, Understood
from .importer.description import outputs as wanted

Tell = Callable[[Diagnostic], None]


def understand_foreign(
    path: Path,
    arguments: Mapping[str, str],
    packages: Mapping[str, Path],
    tell: Tell | None = None,
    trust: bool = False,
) -> Understood:
    """Return what a foreign robot says, as ``pipeline.understand`` does of a description.

    ``arguments`` are those of a xacro file, ``packages`` folders of ROS packages by name. It is read leniently, with
    ``trust`` in what it runs or without; joints are published as in any description.
    """
    imported = read(path, ReadOptions(arguments, packages, lenient=True, tell=tell, trust=trust))
    tree = None if imported.tree is None else _with_published(imported, imported.tree)
    expanded = Expanded(tree, imported.diagnostics, imported.files)
    if tree is None or has_errors(imported.diagnostics):
        return Understood(expanded, None, arrange(imported.diagnostics))
    lowered = lower(tree)
    return Understood(expanded, lowered, arrange([*imported.diagnostics, *lowered.diagnostics]))


def compile_foreign(
    path: Path,
    arguments: Mapping[str, str],
    packages: Mapping[str, Path],
    tell: Tell | None = None,
    trust: bool = False,
) -> Compiled:
    """Return a foreign robot and its URDF, as ``pipeline.compile_robot`` does of a description."""
    expanded, lowered, diagnostics, _ = understand_foreign(path, arguments, packages, tell, trust)
    if lowered is None or lowered.robot is None or has_errors(diagnostics):
        return Compiled(None, (), diagnostics, expanded.files)
    format, (output,) = published(), lowered.robot.outputs
    text, remarks = format.written(lowered.robot, output, Templates(path.parent))
    if path.suffix.lower() in format.endings:
        text = path.read_text("utf-8", "replace")  # what robot_state_publisher was given
    artifact = Artifact(output.file, text, format.name, output.name)
    return Compiled(lowered.robot, (artifact,), arrange([*diagnostics, *remarks]), expanded.files)


def _with_published(imported: Imported, tree: Map) -> Map:
    """Return the tree of a robot with what robot_state_publisher reads as its only output."""
    name = published().name
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        if key != "outputs":
            made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    outputs, output = Map(tree.span), Map(tree.span)
    for key, value in wanted(imported).entries[name].items():
        output.put(key, value, tree.span, tree.span)
    outputs.put(name, output, tree.span, tree.span)
    made.put("outputs", outputs, tree.span, tree.span)
    return made
