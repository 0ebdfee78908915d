"""Write diagnostics for programs and for pull requests: GitHub annotations, SARIF and GitHub Flavored Markdown.

Anybody can change a description in a pull request, so names and messages are put in Markdown only as code. The size of
the Markdown is limited, because a comment on GitHub has at most 65,536 characters.
"""

import json
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import quote

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Span, text
from rosorin_compile.source.messages import add_suggestions, gather
from rosorin_compile.source.rule_registry import OF_PLUGINS, find
from rosorin_compile.source.version import HOME, __version__
from rosorin_compile.source.wording import count_of, phrase, printable

HEAD = "## Robots: "  # the beginning of each Markdown document
MAX_BYTES = 60_000  # limit of the Markdown in UTF-8, which leaves room for text of the user in the same comment
_MAX_NAME, _MAX_TEXT = 200, 1000  # characters
_MOST_LINES = (500, 50, 10)  # lines per block; the first number with which the document is below MAX_BYTES is used


def from_workspace(path: str) -> str:
    """Make a path relative to the root of the checkout, because a GitHub job can run in a subfolder."""
    top = os.environ.get("GITHUB_WORKSPACE", "")
    try:
        relative = os.path.relpath(files.resolve(path), files.resolve(top)) if top else os.pardir
    except (OSError, ValueError):  # the current folder was removed, or the path is invalid
        return path
    return path if relative == os.pardir or relative.startswith(f"{os.pardir}{os.sep}") else relative


def _in_workspace(diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    def moved(span: Span | None) -> Span | None:
        return span and span._replace(source=span.source._replace(path=from_workspace(span.source.path)))

    return [
        replace(d, span=moved(d.span), related=tuple(r._replace(span=moved(r.span)) for r in d.related))
        for d in add_suggestions(diagnostics)
    ]


def github(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as GitHub workflow commands, which mark the lines of a pull request.

    An annotation has only one position, so the message lists the includes and parts that lead there.
    https://docs.github.com/actions/reference/workflow-commands-for-github-actions
    """

    def escaped(value: str) -> str:
        return value.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")

    def attribute(value: str) -> str:
        return escaped(value).replace(":", "%3A").replace(",", "%2C")

    lines = []
    for diagnostic in _in_workspace(diagnostics):
        kind, span = "notice" if diagnostic.severity == NOTE else diagnostic.severity, diagnostic.span
        where = f"file={attribute(span.source.path)},line={span.line},col={span.column}," if span else ""
        message = "\n".join([_with_help(diagnostic), *map(str, diagnostic.related)])
        lines.append(f"::{kind} {where}title={attribute(diagnostic.rule)}::{escaped(message)}\n")
    return "".join(lines)


def _with_help(diagnostic: Diagnostic) -> str:
    return diagnostic.message + (f"; {diagnostic.help}" if diagnostic.help else "")


def sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as SARIF 2.1.0 (https://docs.oasis-open.org/sarif/sarif/v2.1.0/)."""
    ids = sorted({diagnostic.rule for diagnostic in diagnostics})
    known = find(ids)
    rules: list[dict[str, object]] = []
    for id in ids:
        rule = known.get(id) or OF_PLUGINS.get(id)
        rules.append({"id": id, "shortDescription": {"text": rule.what if rule else id.replace("-", " ")}})
        if rule and rule.help:
            rules[-1]["help"] = {"text": rule.help, "markdown": rule.help}
        if HOME and id in known:
            rules[-1]["helpUri"] = f"{HOME}docs/rules.md#{id}"
    driver = {"name": "rosorin-compile", "semanticVersion": __version__, "rules": rules}
    driver |= {"informationUri": HOME} if HOME else {}
    results = []
    for diagnostic in add_suggestions(diagnostics):
        message = [_with_help(diagnostic), *(one.message for one in diagnostic.related if one.span is None)]
        result: dict[str, object] = {"ruleId": diagnostic.rule, "ruleIndex": ids.index(diagnostic.rule)}
        result |= {"level": diagnostic.severity, "message": {"text": "\n".join(message)}}
        if diagnostic.span:
            result["locations"] = [_location(diagnostic.span)]
        unique = dict.fromkeys(diagnostic.related)  # SARIF requires unique related locations
        if related := [{**_location(r.span), "message": {"text": r.message}} for r in unique if r.span]:
            result["relatedLocations"] = related
        results.append(result)
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    schema = "https://json.schemastore.org/sarif-2.1.0.json"
    return json.dumps({"$schema": schema, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _location(span: Span) -> dict[str, object]:
    """Return a SARIF location; its file is a URI reference, relative for a relative path (SARIF 2.1.0, 3.4.3)."""
    uri = quote(os.fsencode(span.source.path))
    uri = f"file://{uri}" if Path(span.source.path).is_absolute() else uri
    region = {"startLine": span.line, "startColumn": span.column, "endColumn": span.column + span.length}
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}


FORMATS: dict[str, Callable[[Sequence[Diagnostic]], str]] = {"text": text, "github": github, "sarif": sarif}


@dataclass
class Section:
    """The section of one robot in a Markdown report: printed lines, failures (``wrong``), differences, diagnostics."""

    name: str
    lines: list[str] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def counts(self, *severities: str) -> list[str]:
        """Return the number of diagnostics of each severity as in "2 errors", without zeros."""
        found = [one.severity for one in self.diagnostics]
        return [count_of(found.count(severity), severity) for severity in severities if severity in found]

    @property
    def failed(self) -> bool:
        return bool(self.wrong or self.counts(ERROR))

    @property
    def quiet(self) -> bool:
        return not (self.failed or self.differences or self.counts(WARNING))


def markdown(sections: Sequence[Section]) -> str:
    """Return a Markdown report: first the robots with something to review, then one line for each other robot."""
    failed = sum(section.failed for section in sections)
    head = f"{HEAD}{failed:,} of {len(sections):,} with problems" if failed else f"{HEAD}no problems"
    quiet = "\n".join(_line(section) for section in sections if section.quiet)
    for most in _MOST_LINES:
        parts = [_section(section, most) for section in sections if not section.quiet]
        document = "\n\n".join(filter(None, [head, *parts, quiet])) + "\n"
        if len(document.encode("utf-8", "replace")) <= MAX_BYTES:
            return document
    document = f"{head}\n\nToo much to show here: see the log of the run.\n\n"
    for number, section in enumerate(sorted(sections, key=lambda section: section.quiet)):
        line = f"{_line(section)}\n"
        if len((document + line).encode("utf-8", "replace")) > MAX_BYTES - 100:
            return f"{document}- and {count_of(len(sections) - number, 'more robot')}\n"
        document += line
    return document


def _line(section: Section) -> str:
    texts = [*section.wrong, *section.lines, *section.counts(ERROR, WARNING, NOTE)]
    return f"- {code(section.name)}: {code('; '.join(texts) or 'nothing to report', _MAX_TEXT)}"


def _section(section: Section, most: int) -> str:
    """Return the paragraphs of one robot, with at most ``most`` lines in each block."""
    verdict = phrase([*section.wrong, *section.counts(ERROR, WARNING)])
    parts = [f"### {code(section.name)}: {verdict}" if section.name else f"### {verdict[:1].upper()}{verdict[1:]}"]
    parts += [code(line.strip(), _MAX_TEXT) for line in section.lines]
    merged = gather(section.diagnostics, [WARNING, NOTE])
    worse, notes = ([one for one in merged if (one.severity == NOTE) == is_note] for is_note in (False, True))
    parts += [_fenced("diff", section.differences, most)] if section.differences else []
    parts += [_fenced("text", text(_in_workspace(worse)).splitlines(), most)] if worse else []
    if notes:
        messages = _fenced("text", text(_in_workspace(notes)).splitlines(), most)
        parts.append(f"<details><summary>{''.join(section.counts(NOTE))}</summary>\n\n{messages}\n\n</details>")
    return "\n\n".join(parts)


def _fenced(kind: str, lines: Sequence[str], most: int) -> str:
    shown = [_cut(printable(line, keep="\t"), _MAX_TEXT) for line in lines[:most]]
    shown += [f"... {count_of(len(lines) - most, 'more line')}"] if len(lines) > most else []
    fence = "`" * max(3, 1 + max((len(run) for line in shown for run in re.findall("`+", line)), default=0))
    return "\n".join([f"{fence}{kind}", *shown, fence])


def _cut(value: str, limit: int) -> str:
    return f"{value[:limit]}..." if len(value) > limit else value


def code(value: str, limit: int = _MAX_NAME) -> str:
    r"""Format text as inline code that is safe in a table, where "|" would end the cell.

    >>> code("base_link"), code("a|b"), code("a`b")
    ('`base_link`', '<code>a&#124;b</code>', '<code>a&#96;b</code>')
    """
    shown = _cut(printable(value), limit)
    if not re.search(r"[`|]|\\$|^\s|\s$|^$", shown):
        return f"`{shown}`"
    escaped = "".join(c if c.isalnum() or c == " " else f"&#{ord(c)};" for c in shown)
    return f"<code>{escaped.replace('&#64;', '&#64;<!-- -->')}</code>"  # keep GitHub from linking e-mail addresses
