"""Compare committed artifacts with those just compiled: by meaning first, then as texts.

Each committed artifact is read back by its format, and compared with what it is meant to contain.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from difflib import unified_diff
from typing import NamedTuple

from rosorin_compile.compare.changes import Change, find_changes
from rosorin_compile.compare.pairs import Pair, pair_of, with_new_names
from rosorin_compile.formats import FORMATS, Artifact, Format
from rosorin_compile.model import Robot
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import counted, printable

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
_MAX_CHANGES = 100
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_NO_END = "\\ No newline at end of file"
_IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"
_MOST_VALUES = 3
_CUT = 60
_TAG = re.compile(r"<([A-Za-z_]\w*)")
_WORD = re.compile(r"[A-Za-z_]\w+")
_MISSING = "missing; rosorin-compile all writes it"
_EXTRA = "no artifact of this robot; remove it, or run rosorin-compile all --prune"
_NOT_TEXT = "the committed file is no UTF-8 text; rosorin-compile all writes it again"
_SAME_MEANING = "same meaning, different text"
_NOTHING_COMPARED = "different text; nothing that is compared by meaning differs"
_LARGEST_PICTURE = 200_000  # letters of a text that is not for people; the lines of a larger one are not shown at all


class TextDifference(NamedTuple):
    """How the text of a file differs: its kind, a remark, and for a changed file the lines of a unified diff.

    ``shown``: whether these say anything to a person; of a picture they do not.
    """

    file: str
    kind: str
    remark: str = ""
    lines: tuple[str, ...] = ()
    shown: bool = True

    @property
    def is_text(self) -> bool:
        """Whether the committed file is text at all."""
        return self.kind != NOT_TEXT


def unified(file: str, old: str, new: str) -> tuple[str, ...]:
    """Return the unified diff from a committed to a compiled text, without line ends, control characters visible."""
    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    if max(len(before), len(after)) > _MAX_COMPARED:
        return (f"{len(before)} lines committed, {len(after)} lines compiled: too many to show how they differ",)
    shown: list[str] = []
    for line in unified_diff(before, after, f"committed/{file}", f"compiled/{file}"):
        shown.append(printable(line.removesuffix("\n"), keep="\t"))
        if not line.endswith("\n"):
            shown.append(_NO_END)
    return tuple(shown)


def shorten(lines: Sequence[str]) -> list[str]:
    """Return the first lines of a diff, long ones cut, and how many there are more."""
    shown = [line if len(line) <= MAX_WIDTH else f"{line[:MAX_WIDTH]}..." for line in lines[:MAX_LINES]]
    if len(lines) > MAX_LINES:
        shown.append(f"... {len(lines) - MAX_LINES} more lines (--full shows them)")
    return shown


def _with_values(remark: str, old: str, new: str) -> str:
    """Return a remark with the first lines of two texts that differ, unless the texts are of different lengths."""
    before, after = old.splitlines(), new.splitlines()
    if len(before) != len(after):
        return remark
    pairs = enumerate(zip(before, after, strict=True), 1)
    found = [_line_change(number, *both) for number, both in pairs if both[0].split() != both[1].split()]
    more = [f"and {len(found) - _MOST_VALUES} more"] if len(found) > _MOST_VALUES else []
    return f"{remark}: {', '.join([*found[:_MOST_VALUES], *more])}" if found else remark


def _line_change(number: int, old: str, new: str) -> str:
    """Return what changed in a line: the words that differ, behind the element, the key or the first word."""
    before, after = old.split(), new.split()
    same: list[str] = []
    for at in (0, -1):  # what both begin and end with
        while before and after and before[at] == after[at]:
            same += after[:1] if at == 0 else []
            del before[at], after[at]
    tags = _TAG.findall(" ".join([*same, *after[:1]]))
    words = tags[-1:] or _WORD.findall(same[-1] if same and len(new) > MAX_WIDTH else new)
    texts = [printable(" ".join(some))[:_CUT] or "nothing" for some in (before, after)]
    return " ".join([f"line {number}", *words[:1]]) + f": {' -> '.join(texts)}"


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
        if artifact.file not in committed:
            texts.append((TextDifference(artifact.file, MISSING, _MISSING), None, ""))
            continue
        try:
            old = committed[artifact.file].decode("utf-8")
        except UnicodeDecodeError:
            texts.append((TextDifference(artifact.file, NOT_TEXT, _NOT_TEXT), None, ""))
            continue
        if old != artifact.text:
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
    """Return a comparison as lines of plain text: changes of meaning, remarks and what to do, then the text diffs.

    Diffs are shortened unless ``full``.
    """
    lines, texts = [change.line() for change in comparison.changes], comparison.texts
    if not full and len(lines) > _MAX_CHANGES:
        lines[_MAX_CHANGES:] = [f"... {counted(len(lines) - _MAX_CHANGES, 'more difference')} (--full shows them)"]
    lines += [f"{printable(text.file)}: {text.remark}" for text in texts if text.remark]
    for text in texts:
        if text.lines and (full or text.shown):
            lines += ["", *(text.lines if full else shorten(text.lines))]
    return [*lines, "", _IF_MEANT] if any(text.kind == CHANGED for text in texts) else lines


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


def _same_syntax(format: Format, old: str, new: str) -> bool:
    """Return True if two texts of a format differ in white space, comments and the spelling of numbers alone."""
    try:
        return format.syntax is not None and bool(format.syntax(old) == format.syntax(new))
    except (ValueError, SyntaxError):
        return False
