"""What keeps numbers from being taken out of a mesh, as a value."""

from __future__ import annotations

from rosorin_compile.diagnostics import Diagnostic, Span, error


class ExtractProblem(Exception):
    """Something that cannot be done; carries the diagnostic that says why, and the way out."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class NotThere(ExtractProblem):
    """What is asked for by name is not there: a file, a robot, a package, a link. For commands it is wrong usage."""


def missing(rule: str, message: str, help: str = "") -> NotThere:
    """Return the problem that nothing has the name that is asked for, to be raised."""
    return NotThere(error(rule, message, None, help))


def fail(rule: str, message: str, help: str = "", span: Span | None = None) -> ExtractProblem:
    """Return a problem, to be raised."""
    return ExtractProblem(error(rule, message, span, help))
