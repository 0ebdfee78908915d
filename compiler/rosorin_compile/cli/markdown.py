"""Write the result of a run as GitHub Flavored Markdown, robot by robot, for a pull request or the summary of a job.

Text of a description may come from anybody who opens a pull request. A word that could be markup (HTML, a mention, a
link, a picture, mathematics) is written as code. The document is bounded: a comment holds 65,536 characters.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from html import escape
from typing import NamedTuple

from rosorin_compile.compare.changes import Change
from rosorin_compile.output.committed import CHANGED, MAX_LINES, TextDifference, shorten
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Span
from rosorin_compile.source.messages import gather
from rosorin_compile.source.wording import and_more, count_of, phrase, plural, printable

from .report_formats import from_workspace

MAX_BYTES = 60_000  # of UTF-8; leaves room for words around the document
HEAD = "## Robots: "  # the beginning of each document
_MAX_CODE = 200  # letters of one name or number
_MAX_TEXT = 1000  # letters of one message
_MAX_NAMES = 12  # in one cell


class Table(NamedTuple):
    """Rows of Markdown under a head; ``noun`` is what one row is."""

    noun: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


class Diff(NamedTuple):
    """A unified diff of a file, folded: its name, a remark, its lines, and how many lines are already left out."""

    name: str
    remark: str
    lines: Sequence[str]
    left: int = 0


Block = Table | Diff


@dataclass
class Section:
    """The result for one robot: its name, lines of text, problems in a few words, differences, and diagnostics."""

    name: str
    lines: list[str] = field(default_factory=list)
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


def blocks(
    changes: Sequence[Change], texts: Sequence[TextDifference], others: Sequence[tuple[str, str]] = ()
) -> list[Block]:
    """Return changes and differences of text as tables; ``others`` are further files, each with a remark."""
    found: list[Block] = []
    if changes:
        rows = [(prose(change.words()), _codes(change.artifacts)) for change in changes]
        found.append(Table("change", ("change", "artifacts"), rows))
    diffs = [text for text in texts if text.kind == CHANGED and text.shown and text.lines]
    # Where the changes explain it, a file whose text is not shown needs no remark.
    unexplained = "" if any(change.artifacts for change in changes) else "different text"
    files = [(text.file, text.remark or unexplained) for text in texts if text not in diffs]
    remarks = [(code(name), prose(remark)) for name, remark in [*files, *others] if remark]
    if remarks:
        found.append(Table("file", ("file", "what is wrong"), remarks))
    for text in diffs:
        shown = shorten(text.lines)[:MAX_LINES]
        found.append(Diff(text.file, text.remark, shown, len(text.lines) - len(shown)))
    return found


def _codes(names: Sequence[str]) -> str:
    """Return names as code, commas between them; of many the first ones and the number of the others."""
    return ", ".join(map(code, names[:_MAX_NAMES])) + and_more(len(names) - _MAX_NAMES)


# How many rows of a table, diffs of a robot and lines of a diff are shown: the first that fits is used.
_DETAILS = ((200, 20, 40), (5, 0, 0))


def document(sections: Sequence[Section]) -> str:
    """Return the Markdown of several robots: those with something to review first, the others a line each."""
    failed = sum(section.failed for section in sections)
    head = f"{HEAD}{failed:,} of {len(sections):,} with problems" if failed else f"{HEAD}no problems"
    quiet = "\n".join(_line(section) for section in sections if section.quiet)
    for details in _DETAILS:
        parts = ["\n\n".join(_section(section, *details)) for section in sections if not section.quiet]
        text = "\n\n".join(filter(None, [head, *parts, quiet])) + "\n"
        if _size(text) <= MAX_BYTES:
            return text
    text = f"{head}\n\nToo much to show here: see the log of the run.\n\n"
    for number, section in enumerate(sorted(sections, key=lambda section: section.quiet)):
        line = f"{_line(section)}\n"
        if _size(text + line) > MAX_BYTES - 100:
            return f"{text}- and {count_of(len(sections) - number, 'more robot')}\n"
        text += line
    return text


def _size(text: str) -> int:
    return len(text.encode("utf-8", "replace"))


def _line(section: Section) -> str:
    texts = [*map(prose, [*section.wrong, *section.lines]), *_counts(section.diagnostics, ERROR, WARNING, NOTE)]
    return f"- {code(section.name)}: {'; '.join(texts) or 'nothing to report'}"


def _counts(diagnostics: Sequence[Diagnostic], *severities: str) -> list[str]:
    """Return the number of diagnostics of each severity; of the notes, how many are stand-ins."""
    counts = {severity: sum(d.severity == severity for d in diagnostics) for severity in severities}
    texts = [count_of(count, severity) for severity, count in counts.items() if count]
    stand_ins = sum(d.rule == "stand-in" for d in diagnostics)
    if stand_ins and NOTE in severities:
        texts[-1] += f" ({count_of(stand_ins, 'stand-in')}: values that have not been measured)"
    return texts


def _section(section: Section, rows: int, max_diffs: int, lines: int) -> Iterator[str]:
    verdict = phrase([*map(prose, section.wrong), *_counts(section.diagnostics, ERROR, WARNING)])
    yield f"### {code(section.name)}: {verdict}" if section.name else f"### {verdict[:1].upper()}{verdict[1:]}"
    yield from (prose(line.strip()) for line in section.lines)
    yield from (_table(block, rows) for block in section.blocks if isinstance(block, Table))
    merged = gather(section.diagnostics, [WARNING, NOTE])
    if worse := [diagnostic for diagnostic in merged if diagnostic.severity != NOTE]:
        yield _table(_diagnostics(worse), rows)
    diffs = [block for block in section.blocks if isinstance(block, Diff)]
    yield from (_diff(diff, lines) for diff in diffs[:max_diffs])
    if len(diffs) > max_diffs:
        yield f"{count_of(len(diffs) - max_diffs, 'text difference')} left out here"
    if notes := [diagnostic for diagnostic in merged if diagnostic.severity == NOTE]:
        yield _folded("".join(_counts(section.diagnostics, NOTE)), _table(_diagnostics(notes), min(rows, 50)))


def _diagnostics(diagnostics: Sequence[Diagnostic]) -> Table:
    def place(span: Span | None) -> str:
        return f"{from_workspace(span.source.path)}:{span.line}:{span.column}" if span else ""

    rows = []
    for d in diagnostics:
        related = (f"{place(r.span)}: {r.message}" if r.span else r.message for r in d.related)
        message = "<br>".join(map(prose, "\n".join([d.message, *related]).split("\n")))
        rows.append((d.severity, code(d.rule), code(place(d.span)) if d.span else "", message, prose(d.help)))
    return Table("message", ("", "rule", "place", "message", "help"), rows)


def _table(table: Table, limit: int) -> str:
    """Return the first rows of a table and the number of the others, without empty columns."""
    columns = [at for at in range(len(table.head)) if any(row[at] for row in table.rows)]
    rows, left = [table.head, ["---"] * len(table.head), *table.rows[:limit]], len(table.rows) - limit
    lines = [f"| {' | '.join(row[at] for at in columns)} |" for row in rows]
    return "\n".join([*lines, "", f"and {left:,} more {plural(table.noun, left)}"] if left > 0 else lines)


def _diff(diff: Diff, limit: int) -> str:
    lines = [printable(line, keep="\t") for line in diff.lines[:limit]]
    if left := diff.left + len(diff.lines) - len(lines):
        lines.append(f"... {count_of(left, 'more line')}")
    remark = diff.remark or "different text"
    remark = remark if prose(remark) == remark else _html_code(remark)
    fence = "`" * max(3, 1 + max((len(run) for line in lines for run in re.findall("`+", line)), default=0))
    return _folded(f"{_html_code(diff.name)}: {remark}", "\n".join([f"{fence}diff", *lines, fence]))


def _html_code(text: str) -> str:
    return f"<code>{escape(_cut(printable(text), _MAX_CODE))}</code>"


def _folded(title: str, text: str) -> str:
    """Return text that opens on a click; ``title`` is HTML."""
    return f"<details><summary>{title}</summary>\n\n{text}\n\n</details>"


def _cut(text: str, limit: int) -> str:
    return f"{text[:limit]}..." if len(text) > limit else text


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
