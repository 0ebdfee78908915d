"""Robots in other formats, compiled as the description that ``import`` would write."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import outputs_of, read
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expand import Expanded
from rosorin_compile.language.lower import lower
from rosorin_compile.output.pipeline import Compiled, Search, Understood, emitted, judged
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Span, arrange, has_errors
from rosorin_compile.source.tree import Map, Seq

if TYPE_CHECKING:
    from pathlib import Path

    from .request import Request


def understand_foreign(request: Request) -> Understood:
    """Read a robot in another format leniently. Raises LoadError for a file of arguments that is invalid."""
    imported = read(request.description.path, _options(request))
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [FORMATS.published().name])
    expanded = Expanded(tree, imported.diagnostics, imported.files)
    if tree is None or has_errors(imported.diagnostics):
        return Understood(expanded, None, arrange(imported.diagnostics))
    lowered = lower(tree)
    return Understood(expanded, lowered, arrange([*imported.diagnostics, *lowered.diagnostics]))


def compile_foreign(request: Request) -> Compiled:
    """Compile a robot in another format to its URDF only. Raises LoadError."""
    return emit_published(understand_foreign(request), request.description.path)


def emit_published(understood: Understood, path: Path) -> Compiled:
    """Return the URDF of a robot that was read with ``understand_foreign``."""
    expanded, lowered, diagnostics, _ = understood
    if lowered is None or lowered.robot is None or has_errors(diagnostics):
        return Compiled(None, (), diagnostics, expanded.files)
    format, (output,) = FORMATS.published(), lowered.robot.outputs
    text, remarks = format.written(lowered.robot, output, Templates(path.parent))
    if path.suffix.lower() in format.endings:
        text = files.read_text(path, errors="replace")  # what robot_state_publisher was given
    artifact = Artifact(output.file, text, format.name, output.name)
    return Compiled(lowered.robot, (artifact,), arrange([*diagnostics, *remarks]), expanded.files)


def emit_foreign(request: Request, search: Search | None, wanted: Sequence[str], lenient: bool = False) -> Compiled:
    """Compile a robot in another format to the outputs that its description would list. Raises LoadError.

    Anything that the artifacts cannot contain is an error, unless ``lenient``.
    """
    path = request.description.path
    imported = read(path, _options(request, lenient))
    names = [format.name for format in FORMATS.values() if not format.reading.optional]
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree, [*names, *wanted])
    return emitted(judged(Expanded(tree, imported.diagnostics, imported.files), wanted), path, search, wanted)


def listed_foreign(request: Request) -> Understood:
    """Read a robot in another format, with the outputs that its description would list. Raises LoadError."""
    imported = read(request.description.path, _options(request))
    tree = None if imported.tree is None else _with_outputs(imported, imported.tree)
    return judged(Expanded(tree, imported.diagnostics, imported.files))


def _options(request: Request, lenient: bool = True) -> ReadOptions:
    return ReadOptions(request.texts(), request.packages, lenient, tell=request.tell, trust=request.trust)


def _with_outputs(imported: Imported, tree: Map, names: Collection[str] | None = None) -> Map:
    """Return the tree of a robot with the outputs that its description would list, or only some of them."""
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        if key != "outputs":
            made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    outputs = Map(tree.span)
    for name, entry in outputs_of(imported).entries.items():
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
