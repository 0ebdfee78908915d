"""Foreign robots in place of a description, for commands that only ask about one or print what it becomes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expand import Expanded
from rosorin_compile.language.lower import lower
from rosorin_compile.output.pipeline import Compiled, Search, Understood, emitted, judged
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Span, arrange, has_errors
from rosorin_compile.source.tree import Map, Seq

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
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [FORMATS.published().name])
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
    format, (output,) = FORMATS.published(), lowered.robot.outputs
    text, remarks = format.written(lowered.robot, output, Templates(path.parent))
    if path.suffix.lower() in format.endings:
        text = files.read_text(path, errors="replace")  # what robot_state_publisher was given
    artifact = Artifact(output.file, text, format.name, output.name)
    return Compiled(lowered.robot, (artifact,), arrange([*diagnostics, *remarks]), expanded.files)


def emit_foreign(
    path: Path,
    arguments: Mapping[str, str],
    packages: Mapping[str, Path],
    tell: Tell | None,
    trust: bool,
    search: Search | None,
    wanted: Sequence[str],
    lenient: bool = False,
) -> Compiled:
    """Return artifacts of a foreign robot, as ``pipeline.compile_robot`` does of the description that is made of it.

    It lists the outputs that such a description lists. What would be left out of the artifacts is an error, unless
    ``lenient``.
    """
    imported = read(path, ReadOptions(arguments, packages, lenient=lenient, tell=tell, trust=trust))
    names = [format.name for format in FORMATS.values() if not format.reading.optional]
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [*names, *wanted])
    return emitted(judged(Expanded(tree, imported.diagnostics, imported.files), wanted), path, search, wanted)


def listed_foreign(
    path: Path, arguments: Mapping[str, str], packages: Mapping[str, Path], tell: Tell | None, trust: bool
) -> Understood:
    """Return what a foreign robot says, with the outputs that its description would list."""
    imported = read(path, ReadOptions(arguments, packages, lenient=True, tell=tell, trust=trust))
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree)
    return judged(Expanded(tree, imported.diagnostics, imported.files))


def _with_outputs(imported: Imported, tree: Map, names: Collection[str] | None = None) -> Map:
    """Return the tree of a robot with the outputs that its description would list, or only some of them."""
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        if key != "outputs":
            made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    outputs = Map(tree.span)
    for name, entry in imported.outputs().entries.items():
        if names is None or name in names:
            output = Map(tree.span)
            for key, value in entry.items():
                output.put(key, _as_tree(value, tree.span), tree.span, tree.span)
            outputs.put(name, output, tree.span, tree.span)
    made.put("outputs", outputs, tree.span, tree.span)
    return made


def _as_tree(value: Any, span: Span) -> Any:
    """Return a value of a format's record as a tree has it, all of it at one place."""
    if isinstance(value, (Map, Seq)):
        return value
    if isinstance(value, Mapping):
        made = Map(span)
        for key, item in value.items():
            made.put(key, _as_tree(item, span), span, span)
        return made
    if isinstance(value, (list, tuple)):
        items = Seq(span)
        for item in value:
            items.put(_as_tree(item, span), span)
        return items
    return value
