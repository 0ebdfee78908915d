"""Diagnostics of the rules about ROS 2, with the severity and the fix of each rule."""

from __future__ import annotations

from collections.abc import Iterable

from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, Span, diagnostic
from rosorin_compile.source.rule_registry import declared


def report(
    rule: str,
    message: str,
    span: Span | None = None,
    help: Help = "",
    related: Iterable[Related] = (),
    severity: str = "",
) -> Diagnostic:
    """Return a diagnostic of one of the rules; severity and help are those of the rule unless others are passed."""
    known = declared(rule)
    return diagnostic(rule, severity or known.severity, message, span, help or known.hint, related)
