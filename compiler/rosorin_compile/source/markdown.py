"""Markdown: what a run has to say, robot by robot, for a pull request or the summary of a job.

What stands in a description may come from anybody who opens a pull request. So no name, message or line of a diff is
markup here: a word that could be any (HTML, a mention, a link, a picture, mathematics) stands as code, where GitHub and
GitLab read none. The whole is bounded, and says what it leaves out.

GitHub Flavored Markdown: https://github.github.com/gfm/. A comment holds 65,536 characters, a summary 1 MiB.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from typing import NamedTuple

from .diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span
from .messages import gathered
from .report import from_workspace
from .wording import counted, listed, plural, printable

# In bytes of UTF-8, which are not fewer than characters: it fits into a comment, and leaves room for words beside it.
MAX_BYTES = 60_000
HEAD = "## Robots: "  # with this each document begins
_MAX_CODE = 200  # letters of one name or number
_MAX_TEXT = 1000  # letters of one message


class Code(str):
    """A name or a number, to be set as code."""

    __slots__ = ()


Cell = tuple[str, ...]  # texts, those that are Code as code


class Table(NamedTuple):
    """Rows under a head; ``noun`` is what one row is."""

    noun: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


class Diff(NamedTuple):
    """How the text of a file differs, folded away: its name, a remark, and lines of a unified diff.

    ``left`` are lines that are left out already.
    """

    name: str
    remark: str
    lines: tuple[str, ...]
    left: int = 0


Block = Table | Diff


@dataclass
class Section:
    """What there is to say of one robot: its name, lines of text, differences, and diagnostics.

    ``wrong`` says in some words what is not as it should be.
    """

    name: str
    said: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether something is wrong that is to be put right."""
        return bool(self.wrong) or any(one.severity == ERROR for one in self.diagnostics)

    @property
    def quiet(self) -> bool:
        """Whether there is nothing that a reviewer has to look at: such a robot is a line of a list."""
        return not (self.failed or self.blocks or any(one.severity == WARNING for one in self.diagnostics))


class _Detail(NamedTuple):
    """How much is shown: rows of a table, diffs of a robot, lines of a diff."""

    rows: int
    diffs: int
    lines: int


# From the whole to verdicts alone: the first one that fits is taken.
_DETAILS = (_Detail(200, 20, 40), _Detail(100, 10, 20), _Detail(50, 5, 10), _Detail(20, 0, 0), _Detail(5, 0, 0))
_VERDICTS = _Detail(0, 0, 0)


def document(sections: Sequence[Section]) -> str:
    """Return what there is to say of some robots: those with something first, the others a line each."""
    for detail in _DETAILS:
        text = _text(sections, detail)
        if _fits(text):
            return text
    return _verdicts(sections)


def _fits(text: str) -> bool:
    return len(text.encode("utf-8", "replace")) <= MAX_BYTES


def _text(sections: Sequence[Section], detail: _Detail) -> str:
    parts = [_head(sections)]
    parts += ["\n\n".join(_section(one, detail)) for one in sections if not one.quiet]
    quiet = [_line(one) for one in sections if one.quiet]
    return "\n\n".join([*parts, "\n".join(quiet)] if quiet else parts) + "\n"


def _verdicts(sections: Sequence[Section]) -> str:
    """Return one line a robot, as many as there is room for."""
    arranged = [_line(one) for one in sorted(sections, key=lambda one: one.quiet)]
    text = [_head(sections), "", "Too much to show here: what moved is in the log of the run.", ""]
    size = MAX_BYTES - 100 - len("\n".join(text).encode())
    for shown, line in enumerate(arranged):
        size -= len(line.encode("utf-8", "replace")) + 1
        if size < 0:
            text.append(f"- and {counted(len(arranged) - shown, 'more robot')}")
            break
        text.append(line)
    return "\n".join(text) + "\n"


def _head(sections: Sequence[Section]) -> str:
    failed = sum(one.failed for one in sections)
    return f"{HEAD}{failed:,} of {len(sections):,} with problems" if failed else f"{HEAD}no problems"


def _line(section: Section) -> str:
    said = [*map(prose, [*section.wrong, *section.said]), *_counts(section.diagnostics, [ERROR, WARNING, NOTE])]
    return f"- {code(section.name)}: {'; '.join(said) or 'nothing to say'}"


def _counts(diagnostics: Sequence[Diagnostic], severities: Sequence[str]) -> list[str]:
    """Return how many diagnostics there are of each severity; of the notes, how many are stand-ins."""
    counts = {one: sum(d.severity == one for d in diagnostics) for one in severities}
    said = [counted(count, one) for one, count in counts.items() if count]
    stand_ins = sum(d.rule == "stand-in" for d in diagnostics)
    if stand_ins and NOTE in severities:
        said[-1] += f" ({counted(stand_ins, 'stand-in')}: values that nobody has measured)"
    return said


def _section(section: Section, detail: _Detail) -> Iterator[str]:
    verdict = listed([*map(prose, section.wrong), *_counts(section.diagnostics, [ERROR, WARNING])])
    yield f"### {code(section.name)}: {verdict}" if section.name else f"### {verdict[:1].upper()}{verdict[1:]}"
    yield from (prose(line.strip()) for line in section.said)
    for block in section.blocks:
        if isinstance(block, Table):
            yield _table(block, detail.rows)
    told = gathered(section.diagnostics, [WARNING, NOTE])
    worse, notes = ([one for one in told if (one.severity == NOTE) is is_note] for is_note in (False, True))
    if worse:
        yield _table(_diagnostics(worse), detail.rows)
    diffs = [block for block in section.blocks if isinstance(block, Diff)]
    for diff in diffs[: detail.diffs]:
        yield _diff(diff, detail.lines)
    left = len(diffs) - detail.diffs
    if left > 0:
        yield f"{counted(left, 'text difference')} left out here"
    if notes:
        title = "".join(_counts(section.diagnostics, [NOTE]))
        yield _folded(title, _table(_diagnostics(notes), min(detail.rows, 50)))


def _diagnostics(diagnostics: Sequence[Diagnostic]) -> Table:
    rows = tuple(
        ((one.severity,), (Code(one.rule),), (Code(_place(one.span)),), _message(one), (one.help,))
        for one in diagnostics
    )
    return Table("message", ("", "rule", "place", "message", "way out"), rows)


def _message(diagnostic: Diagnostic) -> Cell:
    lines = [diagnostic.message, *map(_related, diagnostic.related)]
    return ("\n".join(lines),)


def _related(related: Related) -> str:
    return f"{_place(related.span)}: {related.message}" if related.span else related.message


def _place(span: Span | None) -> str:
    return f"{from_workspace(span.source.path)}:{span.line}:{span.column}" if span else ""


def _table(table: Table, most: int) -> str:
    """Return a table with its first rows, and the number of those that are left out; columns without anything go."""
    columns = [at for at in range(len(table.head)) if any("".join(row[at]) for row in table.rows)]
    rows = [[table.head[at] for at in columns], ["---"] * len(columns)]
    rows += [["".join(_cell(row[at])) for at in columns] for row in table.rows[:most]]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    left = len(table.rows) - most
    if left > 0:
        lines += ["", f"and {left:,} more {plural(table.noun, left)}"]
    return "\n".join(lines if most > 0 else lines[-1:])


def _cell(pieces: Cell) -> Iterator[str]:
    for piece in pieces:
        if isinstance(piece, Code):
            yield code(piece) if piece else ""
        else:
            yield "<br>".join(prose(line) for line in piece.split("\n"))


def _diff(diff: Diff, most: int) -> str:
    lines = [printable(line, keep="\t") for line in diff.lines[:most]]
    left = diff.left + len(diff.lines) - len(lines)
    if left:
        lines.append(f"... {counted(left, 'more line')}")
    remark = diff.remark or "different text"
    said = remark if prose(remark) == remark else f"<code>{_escaped(remark)}</code>"
    title = f"<code>{_escaped(diff.name)}</code>: {said}"
    longest = max((len(run) for line in lines for run in re.findall("`+", line)), default=0)
    fence = "`" * max(3, longest + 1)
    return _folded(title, "\n".join([f"{fence}diff", *lines, fence]))


def _folded(title: str, text: str) -> str:
    """Return something that opens on a click; ``title`` is HTML."""
    return f"<details><summary>{title}</summary>\n\n{text}\n\n</details>"


def _escaped(text: str) -> str:
    return escape(_cut(printable(text), _MAX_CODE))


def _cut(text: str, most: int) -> str:
    return f"{text[:most]}..." if len(text) > most else text


# A word that no Markdown reads anything into; quotes and the like around it are left aside.
_WORDS = re.compile(r"\[[^\[\]]*\]|\S+")
_WORD = re.compile(r"""(?P<before>["'(]*)(?P<core>.*?)(?P<after>["'),.;:?!]*)""", re.DOTALL)
_PLAIN = re.compile(r"(?!www\.|gh-\d|[0-9a-f]{7,40}$)(?:[^\W_]|[-./,'=+%])*", re.IGNORECASE)
_FIRST = re.compile(r"[-+=]+|\d+[.)]")  # what begins a list or underlines a heading


@lru_cache(maxsize=10_000)  # a document that is too long is written again with less of it
def prose(text: str, most: int = _MAX_TEXT) -> str:
    """Return a text in which each word that could be markup stands as code.

    >>> prose('sensor "base_link" has no key "frmae"'), prose("ask @admin, <b>now</b> -> #12")
    ('sensor "`base_link`" has no key "frmae"', 'ask `@admin`, `<b>now</b>` -&gt; `#12`')
    """
    return _WORDS.sub(_word, _cut(printable(text), most))


def _word(found: re.Match[str]) -> str:
    word = found[0]
    if word == "->":
        return "-&gt;"
    if not found.start() and _FIRST.fullmatch(word):
        return code(word)
    parts = _WORD.fullmatch(word)
    before, core, after = parts.groups() if parts else ("", word, "")
    return word if _PLAIN.fullmatch(core) else f"{before}{code(core)}{after}"


def code(text: str) -> str:
    r"""Return a text as code in a line or in a cell of a table, where a bar would end the cell.

    >>> code("base_link"), code("a|b"), code("a`b")
    ('`base_link`', '<code>a&#124;b</code>', '<code>a&#96;b</code>')
    """
    shown = _cut(printable(text), _MAX_CODE)
    if not re.search(r"[`|]|\\$|^\s|\s$|^$", shown):
        return f"`{shown}`"
    made = "".join(c if c.isalnum() or c == " " else f"&#{ord(c)};" for c in shown)
    apart = made.replace("&#64;", "&#64;<!-- -->")  # within an element of HTML an address becomes a link
    return f"<code>{apart}</code>"
