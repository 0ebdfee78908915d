"""Committed: the committed artifacts held against those just compiled, explained by meaning first.

Each artifact is read back by the backend that made it, the committed text and the compiled one, and the two are
compared as facts about the robot. What differs is said once, with the outputs that show it; text differences follow.

Differences of text are unified diffs; two texts may differ in white space, comments and spelling alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Fact, Facts
from rosorin_compile.model import Robot
from rosorin_compile.model.looks import colours_of, is_own
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import counted, printable

from .changes import changes
from .entities import Change, Pair
from .renames import under_new_names
from .text_values import differing
from .view import View, called, view_of

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

    from .overlay import Overlay


_MISSING = "missing; rosorin-compile all writes it"
_EXTRA = "no artifact of this robot; remove it, or run rosorin-compile all --prune"
_NOT_TEXT = "the committed file is no UTF-8 text; rosorin-compile all writes it anew"
_SAME_MEANING = "same meaning, different text"
_NOTHING_COMPARED = "different text; nothing that is compared by meaning differs"
_MAX_CHANGES = 100


class Comparison(NamedTuple):
    """How committed artifacts differ from compiled ones: by meaning, and file by file; ``same`` if nothing differs.

    ``pairs`` are the artifacts that differ and can be read, as they were and as they are.
    """

    changes: tuple[Change, ...]
    texts: tuple[TextDifference, ...]
    same: bool
    pairs: tuple[Pair, ...] = ()

    def overlay(self, robot: Robot) -> Overlay:
        """Return what a robot was under what it is, to be drawn."""
        from .overlay import before

        return before(robot, self.pairs)

    def brief(self) -> str:
        """Return what changed, each once and without its numbers; of many the first ones."""
        from .wording import brief

        return brief(change.text for change in self.changes)


def compare(robot: Robot, artifacts: Sequence[Artifact], committed: Mapping[str, bytes]) -> Comparison:
    """Return how the committed files (bytes by name, see ``output.read_set``) differ from what was just compiled."""
    arranged = sorted(artifacts, key=lambda artifact: (FORMATS[artifact.backend].rank, artifact.output))
    texts: list[TextDifference] = []
    pairs: list[Pair] = []
    for number, artifact in enumerate(arranged):
        Progress.step(f"comparing {artifact.file},", number, len(arranged))
        old = _decoded(committed.get(artifact.file))
        if old is None:
            missing = artifact.file not in committed
            texts.append(TextDifference(artifact.file, *((MISSING, _MISSING) if missing else (NOT_TEXT, _NOT_TEXT))))
        elif old != artifact.text:
            pair = _pair(robot, artifact, old)
            pairs += [pair] if isinstance(pair, Pair) else []
            texts.append(_changed(artifact, old, "" if isinstance(pair, Pair) else pair))
    pairs = under_new_names(pairs)
    extra = sorted(committed.keys() - {artifact.file for artifact in artifacts})
    texts += [TextDifference(file, EXTRA, _EXTRA) for file in extra]
    found = tuple(changes(robot, pairs, _whole(robot, arranged, pairs, committed))) if pairs else ()
    told = {output for change in found for output in change.artifacts}
    by_file = {artifact.file: artifact for artifact in artifacts}
    remarked = sorted(_remarked(text, by_file.get(text.file), told, committed) for text in texts)
    return Comparison(found, tuple(remarked), not remarked, tuple(pairs))


def _whole(
    robot: Robot, artifacts: Sequence[Artifact], pairs: Sequence[Pair], committed: Mapping[str, bytes]
) -> Pair | None:
    """Return the artifact that carries every frame, whether it differs or not; None if there is none to read."""
    for artifact in artifacts:
        if FORMATS[artifact.backend].proving.complete:
            old = _decoded(committed.get(artifact.file))
            if old is None or old != artifact.text:
                return next((pair for pair in pairs if pair.output == artifact.output), None)
            same = _pair(robot, artifact, old)
            return same if isinstance(same, Pair) else None
    return None


def _decoded(data: bytes | None) -> str | None:
    """Return committed bytes as text; None if there are none, or if they are no UTF-8."""
    try:
        return None if data is None else data.decode("utf-8")
    except UnicodeDecodeError:
        return None


def _pair(robot: Robot, artifact: Artifact, old: str) -> Pair | str:
    """Return an artifact as it was and as it is; if the committed text cannot be read, why. Empty: nobody reads it."""
    facts = FORMATS[artifact.backend].facts
    if facts is None:
        return ""
    names = called(robot, artifact)
    given = {link: material.name for link, material in colours_of(robot).items()}
    try:
        before = view_of(_said(facts(old), names, given, robot), names)
    except (ValueError, OverflowError) as problem:
        damage = f"the committed file is damaged and compared as text alone ({printable(str(problem))})"
        return _with_values(damage, old, artifact.text)
    new: View = view_of(_said(facts(artifact.text), names, given, robot), names)
    return Pair(artifact.output, artifact.backend, before, new)


_LOOK = ("red", "green", "blue", "alpha")


def _said(facts: Facts, names: Mapping[str, str], given: Mapping[str, str], robot: Robot) -> Facts:
    """Return facts without the colours that nobody said: of links that are seen as their collision shapes.

    ``given`` are the materials that those links have for that, by link.
    """
    left_out = set[Fact]()
    links = {fact.name for fact in facts if fact.kind == "link"}  # one of them may be no more
    materials = {*given.values(), *(f"{link}_colour" for link in links)} - set(robot.material)
    for fact, value in facts.items():
        label, _, part = fact.quantity.rpartition(" ")
        link = names.get(fact.name, fact.name) if fact.kind == "link" else ""
        if part == _LOOK[0] and (link in given or (fact.kind == "material" and fact.name in materials)):
            look = [fact._replace(quantity=f"{label} {one}".strip()) for one in _LOOK]
            if is_own([float(facts[one].value) for one in look if one in facts]):
                left_out.update(look)
        elif part == "material" and value.value in materials:
            left_out.add(fact)
    return {fact: value for fact, value in facts.items() if fact not in left_out} if left_out else facts


def _changed(artifact: Artifact, old: str, remark: str) -> TextDifference:
    shown = FORMATS[artifact.backend].proving.shown
    large = not shown and max(len(old), len(artifact.text)) > _LARGEST_PICTURE
    lines = () if large else unified(artifact.file, old, artifact.text)
    return TextDifference(artifact.file, CHANGED, remark, lines, shown)


def _remarked(
    text: TextDifference, artifact: Artifact | None, told: set[str], committed: Mapping[str, bytes]
) -> TextDifference:
    """Return a text difference with the remark that no change of meaning goes with it, where that is so."""
    if artifact is None or text.kind != CHANGED or text.remark or artifact.output in told:
        return text
    format = FORMATS[artifact.backend]
    if format.facts is None:
        return text
    old = _decoded(committed[artifact.file]) or ""
    differ = format.proving.differ(old, artifact.text) if format.proving.differ is not None else ""
    if not differ:
        differ = (
            _SAME_MEANING
            if same_syntax(format, old, artifact.text)
            else _with_values(_NOTHING_COMPARED, old, artifact.text)
        )
    return text._replace(remark=differ)


def _with_values(remark: str, old: str, new: str) -> str:
    """Return a remark with the first values of a text that differ."""
    values = differing(old, new)
    return f"{remark}: {values}" if values else remark


def lines(comparison: Comparison, full: bool = False) -> list[str]:
    """Return a comparison as lines of plain text: changes of meaning, remarks and what to do, then the text diffs.

    Diffs are shortened unless ``full``.
    """
    said = [change.line() for change in comparison.changes]
    if not full and len(said) > _MAX_CHANGES:
        said[_MAX_CHANGES:] = [f"... {counted(len(said) - _MAX_CHANGES, 'more difference')} (--full shows them)"]
    said += [f"{printable(text.file)}: {text.remark}" for text in comparison.texts if text.remark]
    for text in comparison.texts:
        if text.lines and (full or text.shown):
            said += ["", *(text.lines if full else shorten(text.lines))]
    if any(text.kind == CHANGED for text in comparison.texts):
        said += ["", "if this is what you meant, run rosorin-compile all and commit what it writes"]
    return said


CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_LARGEST_PICTURE = 200_000  # letters of a text that is not for people; the lines of a larger one are not shown at all
_NO_END = "\\ No newline at end of file"


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
        """Whether the file that stands there is text at all."""
        return self.kind != NOT_TEXT

    def shortened(self) -> list[str]:
        """Return the first lines of the diff, as ``narrowed``, and how many there are more."""
        return shorten(self.lines)


def unified(file: str, old: str, new: str) -> tuple[str, ...]:
    """Return the unified diff from a committed to a compiled text, without line ends, control characters visible."""
    from difflib import unified_diff

    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    if max(len(before), len(after)) > _MAX_COMPARED:
        return (f"{len(before)} lines committed, {len(after)} lines compiled: too many to show how they differ",)
    shown: list[str] = []
    for line in unified_diff(before, after, f"committed/{file}", f"compiled/{file}"):
        shown.append(printable(line.removesuffix("\n"), keep="\t"))
        if not line.endswith("\n"):
            shown.append(_NO_END)
    return tuple(shown)


def narrowed(lines: Sequence[str], most: int) -> list[str]:
    """Return the first lines of a diff, long ones cut around the place where they begin to differ."""
    shown = list(lines[:most])
    for index, line in enumerate(shown):
        if len(line) > MAX_WIDTH:
            shown[index] = _cut(line, _beginning(lines, index))
    return shown


def shorten(lines: Sequence[str]) -> list[str]:
    """Return the first lines of a diff, as ``narrowed``, and how many there are more."""
    shown = narrowed(lines, MAX_LINES)
    if len(lines) > MAX_LINES:
        shown.append(f"... {len(lines) - MAX_LINES} more lines (--full shows them)")
    return shown


def _beginning(lines: Sequence[str], index: int) -> int:
    """Return where a line of a diff begins to differ from the line that takes its place; 0 if none does."""
    sign = lines[index][:1]
    if sign not in ("-", "+"):
        return 0
    start = index
    while start and lines[start - 1][:1] == sign:
        start -= 1
    if sign == "-":
        place = index
        while place < len(lines) and lines[place][:1] == "-":
            place += 1
    else:
        place = start
        while place and lines[place - 1][:1] == "-":
            place -= 1
    place += index - start
    twin = lines[place] if place < len(lines) and place != index else ""
    if twin[:1] not in ("-", "+") or twin[:1] == sign:
        return 0
    return next((at for at, (a, b) in enumerate(zip(lines[index][1:], twin[1:], strict=False), 1) if a != b), 0)


def _cut(line: str, place: int) -> str:
    first = max(1, place - MAX_WIDTH // 3)
    left = "" if first == 1 else "..."
    right = "..." if first + MAX_WIDTH < len(line) else ""
    return f"{line[:1]}{left}{line[first : first + MAX_WIDTH]}{right}"


def same_syntax(format: Format, old: str, new: str) -> bool:
    """Say whether two texts of a format differ in white space, comments and the spelling of numbers alone."""
    if format.proving.syntax is None:
        return False
    try:
        return bool(format.proving.syntax(old) == format.proving.syntax(new))
    except (ValueError, SyntaxError):
        return False
