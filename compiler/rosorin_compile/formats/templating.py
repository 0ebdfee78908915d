"""Templates: Jinja, where an undefined name is an error and XML is escaped.

Templates that ship with the tool are reached as ``rosorin_compile/NAME``; any other name is a file in the folder of the
description, or in that of a plug-in (``Templates.package``). The templates of a description come from strangers: they
are rendered in a child process with limits, in the sandbox of Jinja, where they reach plain values and a few functions.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Mapping
from functools import cache, cached_property
from importlib import import_module
from io import BytesIO
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

import jinja2
from jinja2.exceptions import SecurityError

from rosorin_compile.source import files, system
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, error
from rosorin_compile.source.files import shown as as_shown
from rosorin_compile.source.project import data_folder, homes
from rosorin_compile.source.rule_registry import TEMPLATES, Rule
from rosorin_compile.source.xml.escaping import Markup, escape

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
_XML = (".urdf", ".xml", ".sdf", ".svg", ".html", ".launch", ".srdf", ".xacro")

# How Jinja names a value of the model: 'rosorin_compile.model.robot.Sensor object'.
_INTERNAL = r"'rosorin_compile\.[\w.]*\.(\w+) object'"


@cache
def _own() -> jinja2.Environment:
    """Return what renders the templates that ship with the tool, which need no sandbox."""
    folder = data_folder("templates")
    loader = jinja2.FunctionLoader(lambda name: files.read_text(folder / name))
    return jinja2.Environment(loader=loader, autoescape=_is_xml, **_OPTIONS)  # noqa: S701 - what is XML is escaped


MAX_SECONDS = 5  # of CPU time, for a template of a user
OUT_OF_TIME = f"it takes more than {MAX_SECONDS} s of CPU time"
_PATIENCE = 60  # seconds until a child is stopped: on a busy machine it waits for its turn
# Started by -c: -m would look for modules in the working folder first, which may belong to a stranger.
_START_CHILD = (
    "import sys, json; sys.path[:] = json.loads(sys.argv[1]);"
    "from rosorin_compile.formats.template_child import main; main()"
)


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
    """Renders the templates of the tool, of a plug-in, and those in ``folder``, the folder of a description.

    The names of those of the tool begin with ``BUILTIN``; they and those of plug-ins (``trusted``) are rendered in this
    process, all others in a child process. ``first`` is the first file of the description: if it is a link, templates
    may also be where it leads to (``project.homes``).
    """

    BUILTIN: ClassVar[str] = BUILTIN

    comment = staticmethod(comment)

    def __init__(
        self,
        folder: Path | None = None,
        named: str = "the folder of the description",
        first: Path | None = None,
        trusted: bool = False,
    ) -> None:
        self.folder = folder
        self.named = named
        self.first = first
        self.trusted = trusted
        self.homes = homes(first) if first is not None else ()
        self.used: set[Path] = set()

    @cached_property
    def environment(self) -> jinja2.Environment:
        """The environment of trusted templates."""
        return jinja2.Environment(loader=jinja2.FunctionLoader(self._load), autoescape=_is_xml, **_OPTIONS)  # noqa: S701

    @cached_property
    def sandbox(self) -> jinja2.Environment:
        """The environment of the templates of a description; for use in the child process only."""
        from jinja2.sandbox import ImmutableSandboxedEnvironment

        sandbox = ImmutableSandboxedEnvironment(
            loader=jinja2.FunctionLoader(self._load), autoescape=_is_xml, **_OPTIONS
        )
        del sandbox.globals["lipsum"]  # text that nobody needs in an artifact, as much as is asked for
        del sandbox.filters["random"]  # an artifact is the same each time
        return sandbox

    def read(self) -> tuple[Path, ...]:
        """Return the templates of the description that were used, sorted."""
        return tuple(sorted(file for file in self.used if any(map(file.is_relative_to, self.homes))))

    @staticmethod
    def own(name: str, values: Mapping[str, Any]) -> str:
        """Return the text of a template that the tool itself brings for a format ("core/robot.urdf.jinja")."""
        return _own().get_template(name).render(values)

    def package(self, name: str) -> Templates:
        """Return what renders the templates in the folder ``templates`` of a Python package, and no others."""
        folder = Path(import_module(name).__path__[0], "templates")
        return Templates(folder, f"the package {name}", trusted=True)

    def render(self, name: str, values: Mapping[str, Any], asked: Span | None = None) -> str:
        """Return the text of a template; ``asked`` is the place in the description that names it.

        The values for a template of a description can be pickled: functions are those of a module. Raises
        TemplateProblem with the place in the template that fails.
        """
        if self.trusted or name.startswith(BUILTIN):
            try:
                return self.environment.get_template(name).render(values)
            except Exception as problem:  # a filter of Jinja raises whatever it likes
                raise self._problem(*explain_failure(problem, name), asked) from None
        rendered = _render_in_child(self.folder, self.first, name, values)
        for file in map(Path, rendered.inputs):
            files.record(file, files.version(file))
            self.used |= {file} if files.version(file) else set()
        if rendered.rule:
            raise self._problem(rendered.rule, rendered.message, rendered.template, rendered.line, asked)
        return rendered.text

    def _problem(self, rule: str, message: str, name: str, line: int, asked: Span | None) -> TemplateProblem:
        if rule == "template-missing":
            message = f"there is no template {name} in {self.named}"
            return TemplateProblem(error(rule, message, asked, "check the name"))
        loaded = self._load(name) if line else None
        if loaded is None:
            return TemplateProblem(error(rule, f"{name}: {message}", asked))
        shown = name if name.startswith(BUILTIN) or self.folder is None else as_shown(self.folder / name)
        source = Source(shown, loaded[0])
        width = max(1, len(source.line(line).strip()))
        indent = len(source.line(line)) - len(source.line(line).lstrip())
        return TemplateProblem(error(rule, message, Span(source, line, indent + 1, width)))

    def _load(self, name: str) -> tuple[str, None, Any] | None:
        try:
            path = self._path(name)
            if path is None or not files.is_file(path):
                return None
            if path.stat().st_size > MAX_TEMPLATE:
                raise jinja2.TemplateRuntimeError(f"it is larger than {MAX_TEMPLATE:,} bytes")
            self.used.add(path)
            return files.read_text(path), None, lambda: True
        except (OSError, ValueError):  # a name that no file can have, or no UTF-8
            return None

    def _path(self, name: str) -> Path | None:
        """Return the file of a template name, or None if the name leaves the folder that it may be in."""
        anchor = data_folder("templates") if name.startswith(BUILTIN) else self.folder
        if anchor is None:
            return None
        try:
            path = files.resolve(anchor / name.removeprefix(BUILTIN))
        except (OSError, RuntimeError):  # links that lead round
            return None
        places = (files.resolve(anchor),) if name.startswith(BUILTIN) else (files.resolve(anchor), *self.homes)
        return path if any(path.is_relative_to(place) for place in places) else None


class _Rendered(NamedTuple):
    """The answer of the child: ``text``, or the rule, message, template and line of a failure.

    ``inputs`` are the files that were read or looked for.
    """

    text: str = ""
    rule: str = ""
    message: str = ""
    template: str = ""
    line: int = 0
    inputs: tuple[str, ...] = ()


def _render_in_child(folder: Path | None, first: Path | None, name: str, values: Mapping[str, Any]) -> _Rendered:
    """Render a template in a child process. Returns a failure if it exceeds a limit."""
    import pickle  # with subprocess they take as long to import as a small robot to compile
    import signal
    import subprocess

    system.needs("resource", system.NO_LIMITS)
    path = json.dumps([os.path.abspath(entry) for entry in sys.path if entry])
    command = [sys.executable, "-c", _START_CHILD, path]
    request = BytesIO()
    pickler = pickle.Pickler(request)
    pickler.dispatch_table = {MappingProxyType: lambda proxy: (dict, (dict(proxy),))}
    pickler.dump((folder, first, name, dict(values)))
    # numpy reserves memory for each thread of its libraries.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(  # noqa: S603 - this Python, and arguments that no shell reads
            command, input=request.getvalue(), capture_output=True, timeout=_PATIENCE, env=environment, check=False
        )
    except subprocess.TimeoutExpired:
        return _Rendered(rule="template-failed", message=f"it did not end within {_PATIENCE} s", template=name)
    if done.returncode in (-getattr(signal, "SIGXCPU", 0), -getattr(signal, "SIGKILL", 0)):
        return _Rendered(rule="template-failed", message=OUT_OF_TIME, template=name)
    if done.returncode:
        last = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2] or f"exit code {done.returncode}"
        return _Rendered(rule="template-failed", message=f"the process that renders it ended: {last}", template=name)
    answer = json.loads(done.stdout)
    return _Rendered(**{**answer, "inputs": tuple(answer["inputs"])})


_OPTIONS: dict[str, Any] = {
    "undefined": jinja2.StrictUndefined,
    "trim_blocks": True,
    "lstrip_blocks": True,
    "keep_trailing_newline": True,
}


def _is_xml(name: str | None) -> bool:
    """Return True if a template makes XML, by its name: its values are escaped."""
    return (name or "").removesuffix(".jinja").endswith(_XML)


def explain_failure(problem: BaseException, name: str) -> tuple[str, str, str, int]:
    """Return rule, message, template and line (0 if unknown) of a failure to render the template ``name``."""
    if isinstance(problem, jinja2.TemplateSyntaxError):
        return "template-syntax", problem.message or "not a template", problem.name or name, problem.lineno
    if isinstance(problem, jinja2.TemplateNotFound):
        return "template-missing", "", str(problem.name), 0
    line = _line(problem)
    if isinstance(problem, SecurityError):
        return "template-unsafe", str(problem), name, line
    if isinstance(problem, MemoryError):
        return "template-failed", "it needs too much memory", name, line
    return "template-failed", re.sub(_INTERNAL, r"a \1", str(problem)) or type(problem).__name__, name, line


def _line(problem: BaseException) -> int:
    """Return the template line in the traceback of a failed rendering: Jinja names its frames ``<template>``."""
    line, trace = 0, problem.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == "<template>":
            template = trace.tb_frame.f_globals.get("__jinja_template__")
            # Jinja rewrites the lines of exceptions, but not when the time is up.
            line = template.get_corresponding_lineno(trace.tb_lineno) if template else trace.tb_lineno
        trace = trace.tb_next
    return line
