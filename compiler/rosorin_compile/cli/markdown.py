"""Write the result of a run as GitHub Flavored Markdown, robot by robot, for a pull request or the summary of a job.

Text of a description may come from anybody who opens a pull request. A word that could be markup (HTML, a mention, a
link, a picture, mathematics) is written as code. The document is bounded: a comment holds 65,536 characters.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from typing import NamedTuple

from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Span
from rosorin_compile.source.messages import gathered
from rosorin_compile.source.wording import counted, listed, plural, printable

from .report_formats import from_workspace

MAX_BYTES = 60_000  # of UTF-8; leaves room for words around the document
HEAD = "## Robots: "  # the beginning of each document
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
    """A unified diff of a file, folded: its name, a remark, its lines, and how many lines are already left out."""

    name: str
    remark: str
    lines: tuple[str, ...]
    left: int = 0


Block = Table | Diff


@dataclass
class Section:
    """The result for one robot: its name, lines of text, problems in a few words, differences, and diagnostics."""

    name: str
    said: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    blocks: list[Block] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether there is something to correct."""
        return bool(self.wrong) or any(one.severity == ERROR for one in self.diagnostics)

    @property
    def quiet(self) -> bool:
        """Whether there is nothing for a reviewer: such a robot is a line of a list."""
        return not (self.failed or self.blocks or any(one.severity == WARNING for one in self.diagnostics))


# How many rows of a table, diffs of a robot and lines of a diff are shown: the first that fits is used.
_DETAILS = ((200, 20, 40), (50, 5, 10), (5, 0, 0))


def document(sections: Sequence[Section]) -> str:
    """Return the Markdown of several robots: those with something to review first, the others a line each."""
    failed = sum(one.failed for one in sections)
    head = f"{HEAD}{failed:,} of {len(sections):,} with problems" if failed else f"{HEAD}no problems"
    quiet = "\n".join(_line(one) for one in sections if one.quiet)
    for rows, diffs, lines in _DETAILS:
        parts = ["\n\n".join(_section(one, rows, diffs, lines)) for one in sections if not one.quiet]
        text = "\n\n".join(filter(None, [head, *parts, quiet])) + "\n"
        if _size(text) <= MAX_BYTES:
            return text
    text = f"{head}\n\nToo much to show here: see the log of the run.\n\n"
    for number, section in enumerate(sorted(sections, key=lambda one: one.quiet)):
        line = f"{_line(section)}\n"
        if _size(text + line) > MAX_BYTES - 100:
            return f"{text}- and {counted(len(sections) - number, 'more robot')}\n"
        text += line
    return text


def _size(text: str) -> int:
    return len(text.encode("utf-8", "replace"))


def _line(section: Section) -> str:
    said = [*map(prose, [*section.wrong, *section.said]), *_counts(section.diagnostics, [ERROR, WARNING, NOTE])]
    return f"- {code(section.name)}: {'; '.join(said) or 'nothing to report'}"


def _counts(diagnostics: Sequence[Diagnostic], severities: Sequence[str]) -> list[str]:
    """Return the number of diagnostics of each severity; of the notes, how many are stand-ins."""
    counts = {one: sum(d.severity == one for d in diagnostics) for one in severities}
    texts = [counted(count, one) for one, count in counts.items() if count]
    stand_ins = sum(d.rule == "stand-in" for d in diagnostics)
    if stand_ins and NOTE in severities:
        texts[-1] += f" ({counted(stand_ins, 'stand-in')}: values that have not been measured)"
    return texts


def _section(section: Section, rows: int, most_diffs: int, lines: int) -> Iterator[str]:
    verdict = listed([*map(prose, section.wrong), *_counts(section.diagnostics, [ERROR, WARNING])])
    yield f"### {code(section.name)}: {verdict}" if section.name else f"### {verdict[:1].upper()}{verdict[1:]}"
    yield from (prose(line.strip()) for line in section.said)
    yield from (_table(block, rows) for block in section.blocks if isinstance(block, Table))
    merged = gathered(section.diagnostics, [WARNING, NOTE])
    if worse := [one for one in merged if one.severity != NOTE]:
        yield _table(_diagnostics(worse), rows)
    diffs = [block for block in section.blocks if isinstance(block, Diff)]
    yield from (_diff(diff, lines) for diff in diffs[:most_diffs])
    if len(diffs) > most_diffs:
        yield f"{counted(len(diffs) - most_diffs, 'text difference')} left out here"
    if notes := [one for one in merged if one.severity == NOTE]:
        yield _folded("".join(_counts(section.diagnostics, [NOTE])), _table(_diagnostics(notes), min(rows, 50)))


def _diagnostics(diagnostics: Sequence[Diagnostic]) -> Table:
    def message(one: Diagnostic) -> str:
        related = (f"{_place(r.span)}: {r.message}" if r.span else r.message for r in one.related)
        return "\n".join([one.message, *related])

    rows = [((d.severity,), (Code(d.rule),), (Code(_place(d.span)),), (message(d),), (d.help,)) for d in diagnostics]
    return Table("message", ("", "rule", "place", "message", "help"), tuple(rows))


def _place(span: Span | None) -> str:
    return f"{from_workspace(span.source.path)}:{span.line}:{span.column}" if span else ""


def _table(table: Table, most: int) -> str:
    """Return the first rows of a table and the number of the others, without empty columns."""
    columns = [at for at in range(len(table.head)) if any("".join(row[at]) for row in table.rows)]
    rows = [[table.head[at] for at in columns], ["---"] * len(columns)]
    rows += [["".join(map(_piece, row[at])) for at in columns] for row in table.rows[:most]]
    lines = [f"| {' | '.join(row)} |" for row in rows]
    left = len(table.rows) - most
    return "\n".join([*lines, "", f"and {left:,} more {plural(table.noun, left)}"] if left > 0 else lines)


def _piece(text: str) -> str:
    if isinstance(text, Code):
        return code(text) if text else ""
    return "<br>".join(prose(line) for line in text.split("\n"))


def _diff(diff: Diff, most: int) -> str:
    lines = [printable(line, keep="\t") for line in diff.lines[:most]]
    if left := diff.left + len(diff.lines) - len(lines):
        lines.append(f"... {counted(left, 'more line')}")
    remark = diff.remark or "different text"
    remark = remark if prose(remark) == remark else _html_code(remark)
    fence = "`" * max(3, 1 + max((len(run) for line in lines for run in re.findall("`+", line)), default=0))
    return _folded(f"{_html_code(diff.name)}: {remark}", "\n".join([f"{fence}diff", *lines, fence]))


def _html_code(text: str) -> str:
    return f"<code>{escape(_cut(printable(text), _MAX_CODE))}</code>"


def _folded(title: str, text: str) -> str:
    """Return text that opens on a click; ``title`` is HTML."""
    return f"<details><summary>{title}</summary>\n\n{text}\n\n</details>"


def _cut(text: str, most: int) -> str:
    return f"{text[:most]}..." if len(text) > most else text


# A word that no Markdown reads anything into, without quotes and the like around it.
_WORDS = re.compile(r"\[[^\[\]]*\]|\S+")
_WORD = re.compile(r"""(?P<before>["'(]*)(?P<core>.*?)(?P<after>["'),.;:?!]*)""", re.DOTALL)
_PLAIN = re.compile(r"(?!www\.|gh-\d|[0-9a-f]{7,40}$)(?:[^\W_]|[-./,'=+%])*", re.IGNORECASE)
_FIRST = re.compile(r"[-+=]+|\d+[.)]")  # begins a list or underlines a heading


@lru_cache(maxsize=10_000)  # a document that is too long is written again with less of it
def prose(text: str, most: int = _MAX_TEXT) -> str:
    """Return a text in which each word that could be markup is code.

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
    escaped = "".join(c if c.isalnum() or c == " " else f"&#{ord(c)};" for c in shown)
    return f"<code>{escaped.replace('&#64;', '&#64;<!-- -->')}</code>"  # else an address becomes a link
