"""Write diagnostics for programs: GitHub annotations and SARIF."""

import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from urllib.parse import quote

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Span, text
from rosorin_compile.source.messages import add_suggestions
from rosorin_compile.source.rule_registry import OF_PLUGINS, find
from rosorin_compile.source.version import HOME, __version__


def github(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as GitHub workflow commands, which mark the lines of a pull request.

    An annotation has one place, so the includes and parts that led there are below its message.
    https://docs.github.com/actions/reference/workflow-commands-for-github-actions
    """
    lines = []
    for diagnostic in add_suggestions(diagnostics):
        kind = "notice" if diagnostic.severity == "note" else diagnostic.severity
        where = ""
        if span := diagnostic.span:
            where = f"file={_property(from_workspace(span.source.path))},line={span.line},col={span.column},"
        message = "\n".join([_with_help(diagnostic), *map(str, diagnostic.related)])
        lines.append(f"::{kind} {where}title={_property(diagnostic.rule)}::{_escaped(message)}\n")
    return "".join(lines)


def from_workspace(path: str) -> str:
    """Return a path relative to the top of the checkout, where a job on GitHub works in a folder below it."""
    top = os.environ.get("GITHUB_WORKSPACE", "")
    try:
        relative = os.path.relpath(files.resolve(path), files.resolve(top)) if top else os.pardir
    except (OSError, ValueError):  # the current folder is gone, or a name that no file can have
        return path
    return path if relative == os.pardir or relative.startswith(f"{os.pardir}{os.sep}") else relative


def _with_help(diagnostic: Diagnostic) -> str:
    return diagnostic.message + (f"; {diagnostic.help}" if diagnostic.help else "")


def _escaped(value: str) -> str:
    return value.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(value: str) -> str:
    return _escaped(value).replace(":", "%3A").replace(",", "%2C")


def sarif(diagnostics: Sequence[Diagnostic]) -> str:
    """Return diagnostics as SARIF 2.1.0 (https://docs.oasis-open.org/sarif/sarif/v2.1.0/)."""
    diagnostics = add_suggestions(diagnostics)
    ids = sorted({diagnostic.rule for diagnostic in diagnostics})
    known = find(ids)
    rules: list[dict[str, object]] = []
    for id in ids:
        rule = known.get(id) or OF_PLUGINS.get(id)
        short = rule.what if rule else id.replace("-", " ")
        descriptor: dict[str, object] = {"id": id, "shortDescription": {"text": short}}
        if rule and rule.help:
            descriptor["help"] = {"text": rule.help, "markdown": rule.help}
        if HOME and id in known:
            descriptor["helpUri"] = f"{HOME}docs/rules.md#{id}"
        rules.append(descriptor)
    driver: dict[str, object] = {"name": "rosorin-compile", "semanticVersion": __version__, "rules": rules}
    if HOME:
        driver["informationUri"] = HOME
    results = [_result(diagnostic, ids.index(diagnostic.rule)) for diagnostic in diagnostics]
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    schema = "https://json.schemastore.org/sarif-2.1.0.json"
    return json.dumps({"$schema": schema, "version": "2.1.0", "runs": [run]}, indent=2) + "\n"


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, object]:
    """Return a diagnostic as a result of SARIF; a note without a place goes into the message."""
    remarks = [related.message for related in diagnostic.related if related.span is None]
    result: dict[str, object] = {"ruleId": diagnostic.rule, "ruleIndex": rule, "level": diagnostic.severity}
    result["message"] = {"text": "\n".join([_with_help(diagnostic), *remarks])}
    if diagnostic.span:
        result["locations"] = [_location(diagnostic.span)]
    unique = dict.fromkeys(diagnostic.related)  # as the standard requires
    if related := [{**_location(r.span), "message": {"text": r.message}} for r in unique if r.span]:
        result["relatedLocations"] = related
    return result


def _location(span: Span) -> dict[str, object]:
    """Return a place; its file is a URI reference, relative where the file was named so (SARIF 2.1.0, 3.4.3)."""
    uri = quote(os.fsencode(span.source.path))
    uri = f"file://{uri}" if Path(span.source.path).is_absolute() else uri
    region = {"startLine": span.line, "startColumn": span.column, "endColumn": span.column + span.length}
    return {"physicalLocation": {"artifactLocation": {"uri": uri}, "region": region}}


FORMATS: dict[str, Callable[[Sequence[Diagnostic]], str]] = {"text": text, "github": github, "sarif": sarif}
