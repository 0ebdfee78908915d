"""Compare compiled artifacts with the committed files: artifacts by meaning, meshes by bytes, and with engines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.compare.precision import POSE_NOISE as _NEAR
from rosorin_compile.compare.precision import printed
from rosorin_compile.compare.walk import Address, Leaves, compare_leaves, leaves
from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Mesh
from rosorin_compile.output.committed import Comparison, compare, lines
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, error
from rosorin_compile.source.rule_registry import WRITING, declare
from rosorin_compile.source.wording import listed

if TYPE_CHECKING:
    from rosorin_compile.formats import Artifact
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.formats.format import Refusal
    from rosorin_compile.rules.case import Case

RULES = declare(
    WRITING,
    {
        "outputs-differ": "The committed artifacts are not those of the description (in the forms for programs). Fix: "
        "`rosorin-compile all`, if that is what you meant.",
        "engine-refuses": "The engine that an artifact is for does not load it, or cannot find or read a mesh. `check` "
        "asks MuJoCo, where it is installed; of one that is too old, it is a warning. Fix: As the message says; a mesh "
        "is looked for from the folder of the artifact.",
        "engine-missing": "A note: the engine that an artifact is for is not installed, so that nobody tried to load "
        "the artifact. Fix: Install the engine, such as `pip install mujoco`, where artifacts are checked.",
    },
)


class Committed(NamedTuple):
    """The differences between committed files and compiled artifacts, and why engines reject artifacts.

    ``meshes`` are the mesh files that differ, each with a description of the difference. ``edited`` are the artifacts
    that contradict others which are up to date, so that not the description has changed.
    """

    comparison: Comparison
    committed: Mapping[str, bytes]
    meshes: tuple[tuple[str, str], ...]
    diagnostics: list[Diagnostic]
    folder: Path
    edited: tuple[Artifact, ...] = ()

    @property
    def same(self) -> bool:
        """Whether no file differs."""
        return self.comparison.same and not self.meshes

    def differing(self) -> tuple[str, ...]:
        """Return the names of the files that are not as compiled."""
        return (*(text.file for text in self.comparison.texts), *(name for name, _ in self.meshes))

    def lines(self, full: bool = False) -> list[str]:
        """Return the differences as lines; texts are shortened unless ``full``."""
        outputs = {artifact.output for artifact in self.edited}
        changes = tuple(change for change in self.comparison.changes if not outputs.issuperset(change.artifacts))
        return [
            *(f"{self.folder / one.file} was edited: it differs from the other artifacts" for one in self.edited),
            *lines(self.comparison._replace(changes=changes), full),
            *(f"{name}: {what}" for name, what in self.meshes),
        ]


def compare_committed(
    compiled: Compiled, committed: Mapping[str, bytes], folder: Path, load: Callable[[], Case | None]
) -> Committed:
    """Compare a compiled robot without errors with the files in its outputs folder.

    ``load`` returns the robot with its positions in files, for errors of
    engines.
    """
    if compiled.robot is None:
        raise ValueError("a robot with errors has no artifacts")
    meshes = compiled.mesh_files
    present = [] if meshes.keys() - committed.keys() else [one for one in compiled.artifacts if one.file in committed]
    files = {name: data for name, data in committed.items() if name not in meshes}
    comparison = compare(compiled.robot, compiled.artifacts, files)
    changed = []
    for name, data in meshes.items():
        if data != committed.get(name):
            what = "another file than the mesh is" if name in committed else "missing"
            changed.append((name, f"{what}; rosorin-compile all writes it"))
    found = edited(present, committed) if comparison.changes else ()
    return Committed(comparison, committed, tuple(changed), judged(present, folder, load), folder, found)


def edited(artifacts: Sequence[Artifact], committed: Mapping[str, bytes]) -> tuple[Artifact, ...]:
    """Return the artifacts whose committed text contradicts another artifact that is up to date.

    Had the description changed, that one would have changed, too.
    """
    texts = {artifact.file: committed[artifact.file].decode("utf-8", "replace") for artifact in artifacts}
    readable = [artifact for artifact in artifacts if FORMATS[artifact.backend].read is not None]
    current = [(_leaves(one, one.text), one.text) for one in readable if texts[one.file] == one.text]
    found = []
    for artifact in readable:
        text = texts[artifact.file]
        if text == artifact.text:
            continue
        old, new = _leaves(artifact, text), _leaves(artifact, artifact.text)
        changed = [one.address for one in compare_leaves(old, new, (printed(text), printed(artifact.text)))]
        for leaves_of_other, other in current:
            shared = [one for one in changed if one.quantity in leaves_of_other.get(one[:2], {}) and one[:2] in old]
            parts = [_part(side, shared) for side in (old, new, leaves_of_other)]
            agree = {one.address for one in compare_leaves(parts[1], parts[2], (printed(text), printed(other)), _NEAR)}
            differ = {one.address for one in compare_leaves(parts[0], parts[2], (printed(text), printed(other)), _NEAR)}
            if differ - agree:
                found.append(artifact)
                break
    return tuple(found)


def _part(side: Leaves, addresses: Sequence[Address]) -> Leaves:
    found: Leaves = {}
    for kind, name, quantity in addresses:
        if quantity in side.get((kind, name), {}):
            found.setdefault((kind, name), {})[quantity] = side[kind, name][quantity]
    return found


def _leaves(artifact: Artifact, text: str) -> Leaves:
    read = FORMATS[artifact.backend].read
    try:
        return leaves(read(text)) if read is not None else {}
    except (ValueError, TypeError, OverflowError):
        return {}


def judged(artifacts: Sequence[Artifact], folder: Path, load: Callable[[], Case | None]) -> list[Diagnostic]:
    """Load artifacts in a folder with their engines; return why one is not loaded, and which engines are missing.

    An engine that is too old is a warning, one that is not installed a note.
    """
    diagnostics: list[Diagnostic] = []
    missing: dict[str, list[str]] = {}
    for artifact in artifacts:
        engine = FORMATS[artifact.backend].refusal
        found = engine(artifact.text, (folder / artifact.file).parent) if engine else None
        if found is not None and found.missing:
            missing.setdefault(found.missing, []).append(artifact.file)
        elif found is not None and found.reason:
            diagnostics += _refusal(artifact, found, load)
    for name, files in missing.items():
        message = f"{name} not installed: {listed(files)} {'was' if len(files) == 1 else 'were'} not loaded"
        diagnostics.append(Diagnostic("engine-missing", NOTE, message))
    return diagnostics


def _refusal(artifact: Artifact, found: Refusal, load: Callable[[], Case | None]) -> list[Diagnostic]:
    """Return why an engine does not load an artifact, at the meshes that it names, or else at the output."""
    message = f"MuJoCo cannot load {artifact.file}: {found.reason}"
    if found.outdated:
        return [Diagnostic("engine-refuses", WARNING, message)]
    case = load()
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
    output = case.tree.locate(("outputs", artifact.output), key=True)
    return at_meshes or [error("engine-refuses", message, output.span, "correct what it names")]
