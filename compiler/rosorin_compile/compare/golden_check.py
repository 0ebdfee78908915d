"""Compare committed with compiled artifacts, first their values, then their text, and load them in simulators."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from difflib import unified_diff
from itertools import zip_longest
from pathlib import Path, PurePosixPath
from posixpath import commonprefix
from typing import NamedTuple

from rosorin_compile.formats import FORMATS, Artifact
from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.model import Mesh, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import count_of, phrase, printable

from .artifacts import Change, Pair, find_changes, pair_of, with_new_names
from .precision import NOISE, POSE_NOISE, Precision, printed_precision
from .walk import Address, Leaves, compare_leaves, leaves

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES, MAX_WIDTH = 40, 160  # lines of a shortened diff, and characters per line
_MAX_CHANGES = 100
_MAX_COMPARED = 20_000  # lines; computing a longer diff takes too long
_MAX_VALUE = 60  # characters
_LARGEST_PICTURE = 200_000  # characters; larger pictures are not compared line by line
_REMARKS = {
    MISSING: "missing; rosorin-compile all writes it",
    EXTRA: "no artifact of this robot; remove it, or run rosorin-compile all --prune",
    NOT_TEXT: "the committed file is not UTF-8 text; rosorin-compile all writes it again",
}


class TextDifference(NamedTuple):
    """A difference in the text of a committed file."""

    file: str
    kind: str  # CHANGED, MISSING, EXTRA or NOT_TEXT
    remark: str = ""
    lines: tuple[str, ...] = ()  # the unified diff of a changed file
    shown: bool = True  # False if the diff is not readable, such as the diff of a picture


def _unified(file: str, old: str, new: str) -> tuple[str, ...]:
    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    if max(len(before), len(after)) > _MAX_COMPARED:
        return (f"{len(before)} lines committed, {len(after)} lines compiled: too many to show how they differ",)
    shown: list[str] = []
    for line in unified_diff(before, after, f"committed/{file}", f"compiled/{file}"):
        shown.append(printable(line.removesuffix("\n"), keep="\t"))
        shown += [] if line.endswith("\n") else ["\\ No newline at end of file"]
    return tuple(shown)


def shorten(lines: Sequence[str]) -> list[str]:
    """Shorten a diff: cut long lines, keep the first 40 lines, and append the number of omitted lines."""
    more = [f"... {len(lines) - MAX_LINES} more lines (--full shows them)"] if len(lines) > MAX_LINES else []
    return [line if len(line) <= MAX_WIDTH else f"{line[:MAX_WIDTH]}..." for line in lines[:MAX_LINES]] + more


def _first_difference(old: str, new: str) -> str:
    """Describe the first line that differs: its number, its XML element or YAML key, the old and new words."""
    for number, lines_here in enumerate(zip_longest(old.splitlines(), new.splitlines(), fillvalue=""), 1):
        before, after = (line.split() for line in lines_here)
        if before == after:
            continue
        same = commonprefix([before, after])
        del before[: len(same)], after[: len(same)]
        words = [*before[:1], *after[:1]]
        shared = commonprefix(words)  # a word can contain several elements, so search only up to the difference
        start = shared + re.split(r"[^<\w.-]", words[-1][len(shared) :])[0]
        names = re.findall(r"<([\w.-]+)", " ".join([*same, start]))
        names = names or re.findall(r"\b[a-zA-Z_][\w.-]*", " ".join(same))
        while before and after and before[-1] == after[-1]:
            del before[-1], after[-1]
        values = (printable(" ".join(words))[:_MAX_VALUE] or "nothing" for words in (before, after))
        return f"{' '.join([f'line {number}', *names[-1:]])}: {' -> '.join(values)}"
    return "white space"


class Comparison(NamedTuple):
    """The differences between committed and compiled artifacts, in values and in text."""

    changes: tuple[Change, ...]
    texts: tuple[TextDifference, ...]
    pairs: tuple[Pair, ...] = ()  # the values in artifacts that differ and can be parsed


def compare(robot: Robot, artifacts: Sequence[Artifact], committed: Mapping[str, bytes]) -> Comparison:
    """Compare committed files (contents by file name) with the compiled artifacts of a robot."""
    arranged = sorted(artifacts, key=lambda artifact: (FORMATS[artifact.backend].rank, artifact.output))
    extra = committed.keys() - {artifact.file for artifact in artifacts}
    texts = [TextDifference(file, EXTRA, _REMARKS[EXTRA]) for file in extra]
    pairs: list[Pair] = []
    changed: list[tuple[Artifact, str, str]] = []  # (artifact, committed text, remark)
    for number, artifact in enumerate(arranged):
        Progress.step(f"comparing {artifact.file},", number, len(arranged))
        try:
            old, remark = committed[artifact.file].decode("utf-8"), ""
        except (KeyError, UnicodeDecodeError) as problem:
            kind = MISSING if isinstance(problem, KeyError) else NOT_TEXT
            texts.append(TextDifference(artifact.file, kind, _REMARKS[kind]))
            continue
        if old == artifact.text:
            continue
        try:
            pair = pair_of(robot, artifact, old)
            pairs += [pair] if pair is not None else []
        except ValueError as problem:
            where = _first_difference(old, artifact.text)
            remark = f"the committed file is damaged and compared only as text ({printable(str(problem))}): {where}"
        changed.append((artifact, old, remark))
    pairs = with_new_names(pairs)
    changes = tuple(find_changes(robot, pairs)) if pairs else ()
    explained = {output for change in changes for output in change.artifacts}
    for artifact, old, remark in changed:
        new, format = artifact.text, FORMATS[artifact.backend]
        if not remark and artifact.output not in explained:
            remark = format.differ(old, new) if format.differ is not None else ""
            if not remark and format.read is not None:
                remark = f"different text; nothing that is compared by meaning differs: {_first_difference(old, new)}"
                with suppress(ValueError, SyntaxError):  # compare without spaces and comments
                    if format.syntax is not None and format.syntax(old) == format.syntax(new):
                        remark = "same meaning, different text"
        is_large = not format.shown and max(len(old), len(new)) > _LARGEST_PICTURE
        lines = () if is_large else _unified(artifact.file, old, new)
        texts.append(TextDifference(artifact.file, CHANGED, remark, lines, format.shown))
    return Comparison(changes, tuple(sorted(texts)), tuple(pairs))


def lines(comparison: Comparison, full: bool = False) -> list[str]:
    """Format a comparison as lines of text: changed values, remarks, then text diffs, shortened unless ``full``."""
    lines, texts = [change.line() for change in comparison.changes], comparison.texts
    if not full and len(lines) > _MAX_CHANGES:
        lines[_MAX_CHANGES:] = [f"... {count_of(len(lines) - _MAX_CHANGES, 'more difference')} (--full shows them)"]
    lines += [f"{printable(text.file)}: {text.remark}" for text in texts if text.remark]
    for text in texts:
        if text.lines and (full or text.shown):
            lines += ["", *(text.lines if full else shorten(text.lines))]
    if any(text.kind == CHANGED for text in texts):
        lines += ["", "if this is what you meant, run rosorin-compile all and commit what it writes"]
    return lines


class GoldenDifferences(NamedTuple):
    """The differences between committed files and compiled artifacts, and errors from loading the artifacts."""

    comparison: Comparison
    committed: Mapping[str, bytes]
    meshes: tuple[tuple[str, str], ...]  # (name, description of the difference) of differing mesh files
    diagnostics: list[Diagnostic]
    folder: Path
    edited: tuple[Artifact, ...] = ()  # artifacts that were edited by hand

    def differing_files(self) -> tuple[str, ...]:
        """Return the names of the files that differ from the compiled ones."""
        return (*(text.file for text in self.comparison.texts), *(name for name, _ in self.meshes))

    def lines(self, full: bool = False) -> list[str]:
        """Format the differences as lines of text; long diffs are shortened unless ``full`` is True."""
        outputs = {artifact.output for artifact in self.edited}
        changes = tuple(change for change in self.comparison.changes if not outputs.issuperset(change.artifacts))
        return [
            *(f"{self.folder / one.file} was edited: it differs from the other artifacts" for one in self.edited),
            *lines(self.comparison._replace(changes=changes), full),
            *(f"{name}: {what}" for name, what in self.meshes),
        ]


def compare_committed(
    compiled: CompileResult, committed: Mapping[str, bytes], folder: Path, load: Callable[[], Case | None]
) -> GoldenDifferences:
    """Compare a robot that was compiled without errors with the files in its outputs folder.

    ``committed`` maps file names to contents. ``load`` loads the robot with source positions, so that errors of
    simulators refer to lines of the YAML. Raises ValueError if the robot has errors.
    """
    if compiled.robot is None:
        raise ValueError("a robot with errors has no artifacts")
    meshes = compiled.mesh_files
    present = [] if meshes.keys() - committed.keys() else [one for one in compiled.artifacts if one.file in committed]
    files = {name: data for name, data in committed.items() if name not in meshes}
    comparison = compare(compiled.robot, compiled.artifacts, files)
    whats = {True: "another file than the mesh is", False: "missing"}
    wrong = [name for name, data in meshes.items() if data != committed.get(name)]
    changed = tuple((name, f"{whats[name in committed]}; rosorin-compile all writes it") for name in wrong)
    edited = _edited(present, committed) if comparison.changes else ()
    return GoldenDifferences(comparison, committed, changed, load_all(present, folder, load), folder, edited)


def _edited(artifacts: Sequence[Artifact], committed: Mapping[str, bytes]) -> tuple[Artifact, ...]:
    """Return the artifacts that were edited by hand: their values contradict an artifact that is up to date."""

    def content(artifact: Artifact, text: str) -> tuple[Leaves, Precision]:
        read, found = FORMATS[artifact.backend].read, Leaves()
        with suppress(ValueError, TypeError, OverflowError):
            found = leaves(read(text)) if read is not None else found
        return found, printed_precision(text)

    def differing(one: tuple[Leaves, Precision], other: tuple[Leaves, Precision], tolerance: float) -> set[Address]:
        return {found.address for found in compare_leaves(one[0], other[0], (one[1], other[1]), tolerance)}

    texts = {one.output: committed[one.file].decode("utf-8", "replace") for one in artifacts}
    current = [content(one, one.text) for one in artifacts if texts[one.output] == one.text]

    def is_edited(artifact: Artifact) -> bool:
        old, new = content(artifact, texts[artifact.output]), content(artifact, artifact.text)
        changed = differing(old, new, NOISE)
        for other in current:
            sides = [found for found, _ in (old, new, other)]
            shared = {a for a in changed if all(a.quantity in side.get(a[:2], {}) for side in sides)}
            if shared & (differing(old, other, POSE_NOISE) - differing(new, other, POSE_NOISE)):
                return True
        return False

    return tuple(one for one in artifacts if texts[one.output] != one.text and is_edited(one))


def load_all(artifacts: Sequence[Artifact], folder: Path, load: Callable[[], Case | None]) -> list[Diagnostic]:
    """Load each artifact with the program that reads its format, such as MuJoCo, and return diagnostics.

    The diagnostic is a warning if the program is too old for an artifact, and a note if it is not installed.
    """
    diagnostics: list[Diagnostic] = []
    missing: dict[str, list[str]] = {}
    for artifact in artifacts:
        engine = FORMATS[artifact.backend].refusal
        found = engine(artifact.text, (folder / artifact.file).parent) if engine else None
        if found is not None and found.missing:
            missing.setdefault(found.missing, []).append(artifact.file)
        elif found is not None and found.reason:
            message = f"MuJoCo cannot load {artifact.file}: {found.reason}"
            case = None if found.outdated else load()
            if case is None:
                diagnostics.append(Diagnostic("engine-refuses", WARNING if found.outdated else ERROR, message))
                continue
            help = "correct the file, or name another one; it is looked for from the folder of the artifact"
            at_meshes = [
                case.problem("engine-refuses", message, case.link(link.name, purpose, index, "mesh", "file"), help)
                for link in case.robot.links
                for purpose in ("collision", "visual")
                for index, shape in enumerate(getattr(link, purpose))
                if isinstance(shape.geometry, Mesh) and PurePosixPath(shape.geometry.file).name in found.reason
            ]
            output = case.tree.locate(("outputs", artifact.output), key=True)
            diagnostics += at_meshes or [error("engine-refuses", message, output.span, "correct what it names")]
    for name, files in missing.items():
        message = f"{name} not installed: {phrase(files)} {'was' if len(files) == 1 else 'were'} not loaded"
        diagnostics.append(Diagnostic("engine-missing", NOTE, message))
    return diagnostics
