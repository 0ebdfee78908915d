"""Compare compiled artifacts with the committed files: artifacts by meaning, meshes by bytes, and with engines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.compare.committed import Comparison, compare, lines
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Mesh
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, error
from rosorin_compile.source.rule_registry import WRITING, Rule
from rosorin_compile.source.tree import locate

from . import OutputError, read_set

if TYPE_CHECKING:
    from rosorin_compile.formats import Artifact
    from rosorin_compile.formats.format import Refusal

    from .pipeline import Compiled
    from .request import Request


RULES = (
    Rule(
        "outputs-differ",
        "The committed artifacts are not those of the description (in the forms for programs).",
        "`rosorin-compile all`, if that is what you meant.",
        WRITING,
    ),
    Rule(
        "engine-refuses",
        "The engine that an artifact is for does not load it, or cannot find or read a mesh. `check` asks MuJoCo, "
        "where it is installed; of one that is too old, it is a warning.",
        "As the message says; a mesh is looked for from the folder of the artifact.",
        WRITING,
    ),
)


class Committed(NamedTuple):
    """How committed files differ from what was compiled, and what engines have against them.

    ``comparison`` is None where the folder cannot be read: ``diagnostics`` say why. ``meshes`` are the files beside the
    artifacts that differ, each with what is to say of it.
    """

    comparison: Comparison | None
    committed: Mapping[str, bytes]
    meshes: tuple[tuple[str, str], ...]
    diagnostics: list[Diagnostic]

    @property
    def same(self) -> bool:
        """Whether all could be read, and nothing differs."""
        return self.comparison is not None and self.comparison.same and not self.meshes

    def differing(self) -> tuple[str, ...]:
        """Return the names of the files that are not as compiled."""
        texts = self.comparison.texts if self.comparison is not None else ()
        return (*(text.file for text in texts), *(name for name, _ in self.meshes))

    def lines(self, full: bool = False) -> list[str]:
        """Return in lines how files differ; texts are shortened unless ``full``."""
        said = lines(self.comparison, full) if self.comparison is not None else []
        return said + [f"{name}: {what}" for name, what in self.meshes]


def compare_committed(request: Request, compiled: Compiled) -> Committed:
    """Compare a compiled robot with the files in its outputs folder. Raises ValueError for one with errors."""
    if compiled.robot is None:
        raise ValueError("a robot with errors has no artifacts")
    try:
        committed = read_set(request.description.outputs)
    except OutputError as problem:
        return Committed(None, {}, (), [problem.diagnostic])
    meshes = compiled.mesh_files
    written = [] if meshes.keys() - committed.keys() else [one for one in compiled.artifacts if one.file in committed]
    refusals = refused(request, written)
    path = request.description.path
    files = {name: data for name, data in committed.items() if name not in meshes}
    comparison = compare(compiled.robot, compiled.artifacts, files, Templates(path.parent, first=path))
    changed = [(name, what) for name, data in meshes.items() if (what := _mesh(data, committed.get(name)))]
    return Committed(comparison, committed, tuple(changed), refusals)


def _mesh(compiled: bytes, committed: bytes | None) -> str:
    """Return what is to say of a mesh file beside the artifacts; empty if it is the one that was found."""
    if compiled == committed:
        return ""
    what = "missing" if committed is None else "another file than the mesh is"
    return f"{what}; rosorin-compile all writes it"


def refused(request: Request, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return an error for each artifact that its engine does not load, or for each mesh that keeps it from that.

    An engine that is too old is a warning. Asked are those of which there is a file, with all that stands beside it.

    MuJoCo takes 0.3 s to be imported, and some milliseconds a robot; with meshes 0.5 s, in a process of its own.
    """
    told = []
    for artifact in artifacts:
        ask = FORMATS[artifact.backend].proving.refusal
        found = ask(artifact.text, (request.description.outputs / artifact.file).parent) if ask else None
        if found is not None and found.reason:
            told += _refusal(request, artifact, found)
    return told


def _refusal(request: Request, artifact: Artifact, found: Refusal) -> list[Diagnostic]:
    """Return why an engine does not load an artifact, at the meshes that it names, or else at the output."""
    message = f"MuJoCo cannot load {artifact.file}: {found.reason}"
    if found.outdated:  # which says nothing of the artifact
        return [Diagnostic("engine-refuses", WARNING, message)]
    case = request.understand().case
    if case is None:
        return [error("engine-refuses", message, None)]
    help = "correct the file, or name another one; it is looked for from the folder of the artifact"
    at_meshes = [
        case.problem("engine-refuses", message, case.link(link.name, purpose, index, "mesh", "file"), help)
        for link in case.robot.links
        for purpose in ("collision", "visual")
        for index, shape in enumerate(getattr(link, purpose))
        if isinstance(shape.geometry, Mesh) and PurePosixPath(shape.geometry.file).name in found.reason
    ]
    output = locate(case.tree, ("outputs", artifact.output), key=True)
    return at_meshes or [error("engine-refuses", message, output.span, "correct what it names")]
