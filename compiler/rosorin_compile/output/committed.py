"""Compare committed artifacts with those just compiled, explained by meaning first.

Each committed artifact is read back by its format, and compared with what it is meant to contain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.compare.changes import Change, find_changes
from rosorin_compile.compare.pairs import Pair, pair_of, with_new_names
from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.model import Robot
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import printable

from .text_report import CHANGED, EXTRA, MISSING, NOT_TEXT, TextDifference, differing_values, report_lines, unified

_MISSING = "missing; rosorin-compile all writes it"
_EXTRA = "no artifact of this robot; remove it, or run rosorin-compile all --prune"
_NOT_TEXT = "the committed file is no UTF-8 text; rosorin-compile all writes it again"
_SAME_MEANING = "same meaning, different text"
_NOTHING_COMPARED = "different text; nothing that is compared by meaning differs"
_LARGEST_PICTURE = 200_000  # letters of a text that is not for people; the lines of a larger one are not shown at all


class Comparison(NamedTuple):
    """How committed artifacts differ from compiled ones: by meaning, and file by file; ``same`` if nothing differs.

    ``pairs`` are the artifacts that differ and can be read, as they were and as they are.
    """

    changes: tuple[Change, ...]
    texts: tuple[TextDifference, ...]
    same: bool
    pairs: tuple[Pair, ...] = ()


def compare(robot: Robot, artifacts: Sequence[Artifact], committed: Mapping[str, bytes]) -> Comparison:
    """Return how the committed files (bytes by name, see ``output.read_set``) differ from what was just compiled."""
    arranged = sorted(artifacts, key=lambda artifact: (FORMATS[artifact.backend].rank, artifact.output))
    texts: list[tuple[TextDifference, Artifact | None, str]] = []
    pairs: list[Pair] = []
    for number, artifact in enumerate(arranged):
        Progress.step(f"comparing {artifact.file},", number, len(arranged))
        old = _decoded(committed.get(artifact.file))
        if old is None:
            is_missing = artifact.file not in committed
            kind, remark = (MISSING, _MISSING) if is_missing else (NOT_TEXT, _NOT_TEXT)
            texts.append((TextDifference(artifact.file, kind, remark), None, ""))
        elif old != artifact.text:
            remark = ""
            try:
                pair = pair_of(robot, artifact, old)
                pairs += [pair] if pair is not None else []
            except ValueError as problem:
                remark = f"the committed file is damaged and compared as text alone ({printable(str(problem))})"
                remark = _with_values(remark, old, artifact.text)
            shown = FORMATS[artifact.backend].shown
            is_large = not shown and max(len(old), len(artifact.text)) > _LARGEST_PICTURE
            lines = () if is_large else unified(artifact.file, old, artifact.text)
            texts.append((TextDifference(artifact.file, CHANGED, remark, lines, shown), artifact, old))
    pairs = with_new_names(pairs)
    extra = sorted(committed.keys() - {artifact.file for artifact in artifacts})
    texts += [(TextDifference(file, EXTRA, _EXTRA), None, "") for file in extra]
    changes = tuple(find_changes(robot, pairs)) if pairs else ()
    explained = {output for change in changes for output in change.artifacts}
    remarked = sorted(_remarked(text, artifact, old, explained) for text, artifact, old in texts)
    return Comparison(changes, tuple(remarked), not remarked, tuple(pairs))


def lines(comparison: Comparison, full: bool = False) -> list[str]:
    """Return a comparison as lines of plain text; diffs are shortened unless ``full``."""
    return report_lines([change.line() for change in comparison.changes], comparison.texts, full)


def _decoded(data: bytes | None) -> str | None:
    """Return committed bytes as text; None if there are none, or if they are no UTF-8."""
    try:
        return None if data is None else data.decode("utf-8")
    except UnicodeDecodeError:
        return None


def _remarked(text: TextDifference, artifact: Artifact | None, old: str, explained: set[str]) -> TextDifference:
    """Return a text difference with the remark that no change of meaning goes with it, where that is so."""
    if artifact is None or text.remark or artifact.output in explained:
        return text
    format = FORMATS[artifact.backend]
    remark = format.differ(old, artifact.text) if format.differ is not None else ""
    if not remark and format.read is not None:
        same = _same_syntax(format, old, artifact.text)
        remark = _SAME_MEANING if same else _with_values(_NOTHING_COMPARED, old, artifact.text)
    return text._replace(remark=remark)


def _with_values(remark: str, old: str, new: str) -> str:
    values = differing_values(old, new)
    return f"{remark}: {values}" if values else remark


def _same_syntax(format: Format, old: str, new: str) -> bool:
    """Return True if two texts of a format differ in white space, comments and the spelling of numbers alone."""
    try:
        return format.syntax is not None and bool(format.syntax(old) == format.syntax(new))
    except (ValueError, SyntaxError):
        return False
