"""The API for plug-ins (docs/extend.md), in addition to ``rosorin_compile`` and ``rosorin_compile.model``."""

# fmt: off
# isort: off
from rosorin_compile.cli.command import (
    Command, argument, check, check_options, command, option, robot_argument, robot_options, robots_argument,
)
from rosorin_compile.cli.console import FINE, PROBLEMS
from rosorin_compile.cli.run import Run, for_each
from rosorin_compile.formats.format import Artifact, Format, ImportFile, OutputEntry, Refusal, Unsupported
from rosorin_compile.formats.templating import Templates
from rosorin_compile.language.expression.functions import function
from rosorin_compile.model.sections import Section
from rosorin_compile.request import Request
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import (
    ERROR, NOTE, WARNING, Diagnostic, Related, RequestError, Source, Span, did_you_mean, error,
)
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import Heading, Rule, rule

__all__ = [
    "ERROR", "FINE", "NOTE", "PROBLEMS", "WARNING", "Artifact", "Case", "Command",
    "Description", "Diagnostic", "Format", "Heading", "ImportFile", "OutputEntry",
    "Refusal", "Related", "Request", "RequestError", "Rule", "Run", "Section", "Source", "Span",
    "Templates", "Unsupported", "argument", "check", "check_options", "command", "did_you_mean", "error",
    "for_each", "function", "option", "robot_argument", "robot_options",
    "robots_argument", "rule",
]
# isort: on
# fmt: on
