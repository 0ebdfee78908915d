"""Templates: Jinja, where an undefined name is an error and XML is escaped; foreign ones in its sandbox.

Templates that ship with the tool are reached as ``rosorin_compile/NAME``; any other name is a file in the folder of the
description, or in that of a plug-in (``Templates.package``). Foreign templates are safe to render: they reach plain
values and a few functions, no Python.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar

import jinja2

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, error
from rosorin_compile.source.project import data_folder, homes
from rosorin_compile.source.project import shown as as_shown
from rosorin_compile.source.rule_registry import TEMPLATES, Rule
from rosorin_compile.source.xml.escaping import Markup, escape

from .sandbox import Sandbox, options

RULES = (
    Rule(
        "template-missing",
        "There is no such template in the folder of the description.",
        "Check the name.",
        TEMPLATES,
    ),
    Rule("template-syntax", "A template is not legal Jinja.", "Correct the line that is shown.", TEMPLATES),
    Rule(
        "template-failed",
        "A template asks for a name that does not exist, or fails in another way.",
        "[Names in a template](artifacts.md#names-in-a-template).",
        TEMPLATES,
    ),
    Rule("template-unsafe", "A template tries to leave the sandbox.", "Templates reach values, no Python.", TEMPLATES),
)

BUILTIN = "rosorin_compile/"
MAX_TEMPLATE = 10_000_000  # bytes

# How Jinja names a value of the model: 'rosorin_compile.model.robot.Sensor object'.
_INTERNAL = r"'rosorin_compile\.[\w.]*\.(\w+) object'"


@cache
def _own() -> jinja2.Environment:
    """Return what renders the templates that ship with the tool, which need no sandbox."""
    folder = data_folder("templates")
    loader = jinja2.FunctionLoader(lambda name: files.read_text(folder / name))
    return jinja2.Environment(loader=loader, **options())  # noqa: S701 - what is XML is escaped


class TemplateProblem(Exception):
    """A template that is missing, wrong, or asks for what is not there; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


def attributes(**values: str) -> Markup:
    """Return the attributes of an XML element, each with a space before it; the values are escaped.

    A large robot has tens of thousands of them, and Jinja takes its time over each expression of a template.
    """
    text = "".join([f' {name}="{value}"' for name, value in values.items()])
    if text.count('"') != 2 * len(values) or "&" in text or "<" in text or ">" in text or "'" in text:
        text = "".join([f' {name}="{escape(value)}"' for name, value in values.items()])
    return Markup(text)


def attribute(name: str, value: str) -> str:
    """Return one attribute, as ``attributes`` does; quicker of a name, as most of them are."""
    return f' {name}="{value}"' if value.isidentifier() else attributes(**{name: value})


def comment(text: str) -> str:
    """Return text that may stand in an XML comment, where two hyphens in a row may not (XML 1.0, 2.5)."""
    return re.sub("-(?=-)", "- ", f"{text} " if text.endswith("-") else text)


class Templates:
    """Renders the templates of the tool and those in ``folder``, the folder of a description.

    The names of those of the tool begin with ``BUILTIN``.
    ``first`` is the first file of that description: where it is a link, so may the templates be (``project.homes``).
    """

    BUILTIN: ClassVar[str] = BUILTIN

    comment = staticmethod(comment)

    def __init__(
        self, folder: Path | None = None, named: str = "the folder of the description", first: Path | None = None
    ) -> None:
        self.folder = folder
        self.named = named
        self.homes = homes(first) if first is not None else ()
        self.used: set[Path] = set()
        self.asked: Span | None = None

    @cached_property
    def environment(self) -> Sandbox:
        """The sandbox of Jinja."""
        return Sandbox(loader=jinja2.FunctionLoader(self._load), **options())

    def read(self) -> tuple[Path, ...]:
        """Return the templates of the description that were used, sorted."""
        return tuple(sorted(file for file in self.used if any(map(file.is_relative_to, self.homes))))

    @staticmethod
    def own(name: str, values: Mapping[str, Any]) -> str:
        """Return the text of a template that the tool itself brings for a format ("core/robot.urdf.jinja")."""
        return _own().get_template(name).render(values)

    def package(self, name: str) -> Templates:
        """Return what renders the templates in the folder ``templates`` of a Python package, and no others."""
        return Templates(Path(import_module(name).__path__[0], "templates"), f"the package {name}")

    def render(self, name: str, values: Mapping[str, Any], asked: Span | None = None) -> str:
        """Return the text of a template; ``asked`` is the place in the description that names it.

        Raises TemplateProblem with the place in the template that fails.
        """
        self.environment.begin()
        self.asked = asked
        try:
            return self.environment.get_template(name).render(values)
        except jinja2.TemplateSyntaxError as problem:
            line, where = problem.lineno, problem.name or name
            raise self._problem("template-syntax", problem.message or "not a template", where, line, asked) from None
        except jinja2.TemplateNotFound as problem:
            message = f"there is no template {problem.name} in {self.named}"
            raise TemplateProblem(error("template-missing", message, asked, "check the name")) from None
        except jinja2.exceptions.SecurityError as problem:
            raise self._problem("template-unsafe", str(problem), name, _line(problem), asked) from None
        except TemplateProblem:
            raise
        except Exception as problem:  # a filter of Jinja raises whatever comes, AssertionError among them
            message = re.sub(_INTERNAL, r"a \1", str(problem)) or type(problem).__name__
            raise self._problem("template-failed", message, name, _line(problem), asked) from None

    def _problem(self, rule: str, message: str, name: str, line: int, asked: Span | None) -> TemplateProblem:
        loaded = self._load(name)
        if loaded is None or not line:
            return TemplateProblem(error(rule, f"{name}: {message}", asked))
        text = loaded[0]
        shown = name if name.startswith(BUILTIN) or self.folder is None else as_shown(self.folder / name)
        source = Source(shown, text)
        width = max(1, len(source.line(line).strip()))
        indent = len(source.line(line)) - len(source.line(line).lstrip())
        return TemplateProblem(error(rule, message, Span(source, line, indent + 1, width)))

    def _load(self, name: str) -> tuple[str, None, Any] | None:
        try:
            path = self._path(name)
            if path is None or not files.is_file(path):
                return None
            if path.stat().st_size > MAX_TEMPLATE:
                message = f"template {name} is larger than {MAX_TEMPLATE:,} bytes"
                raise TemplateProblem(error("template-failed", message, self.asked, "name a template"))
            self.used.add(path)
            return files.read_text(path), None, lambda: True
        except (OSError, ValueError):  # a name that no file can have, or no UTF-8
            return None

    def _path(self, name: str) -> Path | None:
        """Return the file of a template name; None if the name leaves the folder that it may stand in."""
        anchor = data_folder("templates") if name.startswith(BUILTIN) else self.folder
        if anchor is None:
            return None
        try:
            path = files.resolve(anchor / name.removeprefix(BUILTIN))
        except (OSError, RuntimeError):  # links that lead round
            return None
        places = (files.resolve(anchor),) if name.startswith(BUILTIN) else (files.resolve(anchor), *self.homes)
        return path if any(path.is_relative_to(place) for place in places) else None


def _line(problem: BaseException) -> int:
    """Return the template line in the traceback of a failed rendering: Jinja names its frames ``<template>``."""
    line, trace = 0, problem.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == "<template>":
            line = trace.tb_lineno
        trace = trace.tb_next
    return line
