"""The pipeline: load -> expand -> validate -> build -> check -> emit. Values in, values and diagnostics out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from .accepting import settled, unknown
from .build import Built, build
from .diagnostic import Diagnostic, arrange, error, has_errors
from .emit import FORMATS, Artifact
from .expand import Expanded, expand
from .expand.vendor import Tell
from .expression.functions import plugged as plugged_functions
from .importing import Readers
from .model import Robot
from .rules import acceptable, check, plugged
from .tree import Map, locate
from .validate import validate


class Compiled(NamedTuple):
    """What became of a description: the model and the artifacts (both only without errors), and all that is to say.

    ``inputs`` are the files that were read, templates of the description included.
    """

    robot: Robot | None
    artifacts: tuple[Artifact, ...]
    diagnostics: list[Diagnostic]
    inputs: tuple[Path, ...]


class Understood(NamedTuple):
    """What a description says: its tree, its model and where it was written (each only as far as it was right)."""

    expanded: Expanded
    built: Built | None
    diagnostics: list[Diagnostic]


def understand(path: Path, arguments: Mapping[str, Any] | None = None, tell: Tell | None = None) -> Understood:
    """Return what the description whose first file is ``path`` says; nothing is emitted.

    ``tell`` takes what has to be said before anything is run; without it, that is among the diagnostics.
    """
    expanded = expand(path, arguments or {}, Readers(), tell)
    said = [*expanded.diagnostics, *plugged_functions().diagnostics, *plugged().diagnostics]
    if expanded.tree is None:
        return Understood(expanded, None, arrange(said))
    diagnostics = [*said, *validate(expanded.tree, FORMATS), *unknown(expanded.tree, acceptable())]
    if has_errors(diagnostics):
        return Understood(expanded, None, arrange(diagnostics))
    built = build(expanded.tree)
    diagnostics += built.diagnostics
    if built.robot is not None:
        diagnostics += check(built.robot, expanded.tree, built.places, FORMATS)
    diagnostics = settled(expanded.tree, diagnostics, acceptable(), complete=built.robot is not None)
    return Understood(expanded, built, arrange(diagnostics))


def compile_robot(path: Path, arguments: Mapping[str, Any] | None = None, tell: Tell | None = None) -> Compiled:
    """Compile the description whose first file is ``path``; nothing is written.

    ``arguments`` are texts by name, as on the command line. Problems are diagnostics, never exceptions. ``tell`` as in
    ``understand``.
    """
    expanded, built, diagnostics = understand(path, arguments, tell)
    if expanded.tree is None or built is None or built.robot is None or has_errors(diagnostics):
        return Compiled(None, (), diagnostics, expanded.files)
    artifacts, said, templates = _emit(built.robot, expanded.tree, path.parent)
    if has_errors(said):
        artifacts = ()
    return Compiled(built.robot, artifacts, arrange([*diagnostics, *said]), (*expanded.files, *templates))


def _emit(robot: Robot, tree: Map, folder: Path) -> tuple[tuple[Artifact, ...], list[Diagnostic], tuple[Path, ...]]:
    """Return the artifacts that the robot's outputs ask for, what the formats cannot say, and the templates used."""
    from .templating import TemplateProblem, Templates

    templates = Templates(folder)
    artifacts: list[Artifact] = []
    diagnostics: list[Diagnostic] = []
    for output in robot.outputs:
        place = locate(tree, ("outputs", output.name), key=True)
        try:
            text, said = FORMATS[output.backend].written(robot, output, templates)
        except TemplateProblem as problem:
            found = problem.diagnostic
            diagnostics.append(found if found.span else error(found.rule, found.message, place.span, found.help))
            continue
        diagnostics += [d if d.span else d._replace(span=place.span) for d in said]
        artifacts.append(Artifact(output.file, text, output.backend, output.name))
    own = tuple(sorted(path for path in templates.used if path.is_relative_to(folder.resolve())))
    return tuple(artifacts), diagnostics, own
