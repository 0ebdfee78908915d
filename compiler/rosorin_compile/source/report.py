"""Report: diagnostics as text for people, and as json, github or sarif for programs."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from . import files
from .wording import printable

if TYPE_CHECKING:
    from .diagnostics import Diagnostic, Related, Span

NOTE = "note"

RED, YELLOW, BLUE, BOLD, PLAIN = "\033[31m", "\033[33m", "\033[34m", "\033[1m", "\033[0m"
_COLOURS = {"error": RED, "warning": YELLOW, "note": BLUE}
MAX_SHOWN = 160

# Where a browser finds the files of the project, ending in "/". Nowhere yet: nothing leads there until a person gives
# an address (RELEASING.md). SARIF's links and the urls of the package, which setup.py writes, come of it.
HOME = ""


def text(diagnostics: Sequence[Diagnostic], colour: bool = False) -> str:
    """Return diagnostics as a person reads them: place, message, the line of the file, the way out."""
    return "".join(_text(diagnostic, colour) for diagnostic in diagnostics)


def _text(diagnostic: Diagnostic, colour: bool) -> str:
    head = f"{diagnostic.severity}[{diagnostic.rule}]"
    message = printable(diagnostic.message)
    if colour:
        head, message = _COLOURS[diagnostic.severity] + head + PLAIN, BOLD + message + PLAIN
    lines = [f"{_place(diagnostic.span)}{head}: {message}"]
    if diagnostic.span and diagnostic.severity != NOTE:
        lines += _excerpt(diagnostic.span, diagnostic.help)
    elif diagnostic.help:
        lines.append(f"    {printable(diagnostic.help)}")
    lines += [_related(related) for related in diagnostic.related]
    return "\n".join(lines) + "\n"


def _place(span: Span | None) -> str:
    return f"{printable(span.source.path)}:{span.line}:{span.column}: " if span else ""


def _excerpt(span: Span, help: str) -> list[str]:
    """Return the line of the file and a row of carets under the place; a long line is shown around the place."""
    line = span.source.line(span.line)
    first = max(0, span.column - 1 - MAX_SHOWN // 2) if len(line) > MAX_SHOWN else 0
    shown = printable(line[first : first + MAX_SHOWN].replace("\t", " "))
    column = min(span.column - 1 - first, len(shown))
    carets = "^" * max(1, min(span.length, len(shown) - column))
    below = f"{' ' * column}{carets} {printable(help)}".rstrip()
    return [f"{span.line:5} | {shown}".rstrip(), f"{'':5} | {below}"]


def _related(related: Related) -> str:
    return f"      {_place(related.span)}{printable(related.message)}"


def github(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as GitHub workflow commands, which mark the lines of a pull request.

    An annotation has one place, so the includes and parts that led there stand below its message.
    https://docs.github.com/actions/reference/workflow-commands-for-github-actions
    """
    lines = []
    for diagnostic in diagnostics:
        kind = "notice" if diagnostic.severity == NOTE else diagnostic.severity
        where = ""
        if diagnostic.span:
            span = diagnostic.span
            where = f"file={_property(from_workspace(span.source.path))},line={span.line},col={span.column},"
        message = "\n".join([_with_help(diagnostic), *(_related(related).strip() for related in diagnostic.related)])
        lines.append(f"::{kind} {where}title={_property(diagnostic.rule)}::{_escaped(message)}")
    return "".join(line + "\n" for line in lines)


def from_workspace(path: str) -> str:
    """Return a path as the top of a checkout sees it, where a job on GitHub works in a folder below it."""
    top = os.environ.get("GITHUB_WORKSPACE", "")
    if not top:
        return path
    try:
        relative = os.path.relpath(files.resolve(path), files.resolve(top))
    except (OSError, ValueError):  # the folder of this process is gone, or a name that no file can have
        return path
    return path if relative == os.pardir or relative.startswith(f"{os.pardir}{os.sep}") else relative


def _with_help(diagnostic: Diagnostic) -> str:
    return diagnostic.message + (f"; {diagnostic.help}" if diagnostic.help else "")


def _escaped(value: str) -> str:
    return value.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(value: str) -> str:
    return _escaped(value).replace(":", "%3A").replace(",", "%2C")


def as_object(diagnostic: Diagnostic) -> dict[str, object]:
    """Return a diagnostic as JSON has it."""
    related = [{"message": r.message, **_where(r.span)} for r in diagnostic.related]
    return {
        "rule": diagnostic.rule,
        "severity": diagnostic.severity,
        "message": diagnostic.message,
        **_where(diagnostic.span),
        "help": diagnostic.help,
        "related": related,
    }


def _where(span: Span | None) -> dict[str, object]:
    if span is None:
        return {}
    return {"file": span.source.path, "line": span.line, "column": span.column, "length": span.length}


def sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as SARIF 2.1.0 (https://docs.oasis-open.org/sarif/sarif/v2.1.0/)."""
    import json

    from .version import __version__

    ids = sorted({diagnostic.rule for diagnostic in diagnostics})
    rules = _descriptors(ids)
    driver: dict[str, object] = {"name": "rosorin-compile", "semanticVersion": __version__, "rules": rules}
    if HOME:
        driver["informationUri"] = HOME
    results = [_result(diagnostic, ids.index(diagnostic.rule)) for diagnostic in diagnostics]
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    schema = "https://json.schemastore.org/sarif-2.1.0.json"
    return json.dumps({"$schema": schema, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _descriptors(ids: Sequence[str]) -> list[dict[str, object]]:
    """Return what SARIF says of rules: what each means, the way out, and where the page of rules says so (3.49)."""
    from .rule_registry import OF_PLUGINS, find

    known = find(ids)
    made: list[dict[str, object]] = []
    for id in ids:
        rule = known.get(id) or OF_PLUGINS.get(id)
        descriptor: dict[str, object] = {"id": id}
        descriptor["shortDescription"] = {"text": rule.what if rule else id.replace("-", " ")}
        if rule and rule.help:
            descriptor["help"] = {"text": rule.help, "markdown": rule.help}
        if HOME and id in known:
            descriptor["helpUri"] = f"{HOME}docs/rules.md#{id}"
        made.append(descriptor)
    return made


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, object]:
    """Return a diagnostic as a result of SARIF; a note without a place goes into the message."""
    remarks = [related.message for related in diagnostic.related if related.span is None]
    result: dict[str, object] = {
        "ruleId": diagnostic.rule,
        "ruleIndex": rule,
        "level": diagnostic.severity,
        "message": {"text": "\n".join([_with_help(diagnostic), *remarks])},
    }
    if diagnostic.span:
        result["locations"] = [_location(diagnostic.span)]
    several = dict.fromkeys(diagnostic.related)  # each once, as the standard asks
    related = [{**_location(r.span), "message": {"text": r.message}} for r in several if r.span]
    if related:
        result["relatedLocations"] = related
    return result


def _location(span: Span) -> dict[str, object]:
    """Return a place; its file is a URI reference, relative where the file was named so (SARIF 2.1.0, 3.4.3)."""
    from pathlib import Path
    from urllib.parse import quote

    path = os.fsencode(span.source.path)
    uri = f"file://{quote(path)}" if Path(span.source.path).is_absolute() else quote(path)
    region = {"startLine": span.line, "startColumn": span.column, "endColumn": span.column + span.length}
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}


FORMATS: dict[str, Callable[[Sequence[Diagnostic]], str]] = {
    "text": text,
    "github": github,
    "sarif": sarif,
}
