"""The names of which plug-ins are made (docs/extend.md): records of formats, rules, sections, commands and checks.

They are public beside those of ``rosorin_compile`` and ``rosorin_compile.model``.
"""

from __future__ import annotations

from rosorin_compile.cli.answer import FINE, PROBLEMS, give_result
from rosorin_compile.cli.command import (
    Check,
    Command,
    Options,
    argument,
    check,
    check_options,
    command,
    option,
    robot_argument,
    robot_options,
    robots_argument,
)
from rosorin_compile.cli.run import Run, for_each
from rosorin_compile.formats.format import Artifact, Asked, Format, Opened, Refusal, Unsupported
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expression.functions import function
from rosorin_compile.model.sections import Section
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    Related,
    RequestError,
    Source,
    Span,
    did_you_mean,
    error,
)
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import Heading, Rule, rule

# fmt: off
__all__ = [
    "ERROR", "FINE", "NOTE", "PROBLEMS", "WARNING", "Artifact", "Asked", "Case", "Check", "Command",
    "Description", "Diagnostic", "Format", "Heading", "Opened", "Options",
    "Refusal", "Related", "Request", "RequestError", "Rule", "Run", "Section", "Source", "Span",
    "Templates", "Unsupported", "argument", "check", "check_options", "command", "did_you_mean", "error",
    "for_each", "function", "give_result", "option", "robot_argument", "robot_options",
    "robots_argument", "rule",
]
# fmt: on
