"""Render Jinja templates with escaped XML and with errors for undefined names; define the format ``template``.

The templates of the program and of plug-ins are rendered in this process. The templates of a description may be
untrusted, so they are rendered in a child process with resource limits, in Jinja's sandbox, with plain values only.
"""

from __future__ import annotations

import json
import math
import os
import re
import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from importlib import import_module
from io import BytesIO
from operator import attrgetter
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import jinja2
from jinja2.bccache import Bucket
from jinja2.exceptions import SecurityError
from markupsafe import Markup, escape

from rosorin_compile.model import Output, Robot
from rosorin_compile.source import files, system
from rosorin_compile.source.cache import cache_folder
from rosorin_compile.source.diagnostics import Diagnostic, Source, Span, error
from rosorin_compile.source.numbers import exact, short, six, to_fixed, vector
from rosorin_compile.source.project import data_folder, homes

from .format import Format, describe

MAX_TEMPLATE = 10_000_000  # bytes
MAX_SECONDS = 5  # of CPU time
MAX_MEMORY = 700_000_000  # bytes, in addition to the interpreter and the robot
MAX_OUTPUT = 50_000_000  # characters
_OUT_OF_TIME = f"it takes more than {MAX_SECONDS} s of CPU time"
_PATIENCE = 60  # s of wall-clock time, which can be much longer than the CPU time on a busy machine
_XML = (".urdf", ".xml", ".sdf", ".svg", ".html", ".launch", ".srdf", ".xacro")
# A value of the robot model in Jinja's messages, such as 'rosorin_compile.model.robot.Sensor object'.
_INTERNAL = r"'rosorin_compile\.[\w.]*\.(\w+) object'"
# Use -c, because -m would import modules from the working directory, which may be untrusted.
_START_CHILD = "import sys, json; sys.path[:] = json.loads(sys.argv[1]);"
_START_CHILD += "from rosorin_compile.formats.templating import render_request; render_request()"
_OPTIONS: dict[str, Any] = dict.fromkeys(("trim_blocks", "lstrip_blocks", "keep_trailing_newline"), True)
_OPTIONS |= {"autoescape": lambda name: (name or "").removesuffix(".jinja").endswith(_XML)}
_OPTIONS |= {"undefined": jinja2.StrictUndefined}


class _BytecodeCache(jinja2.FileSystemBytecodeCache):
    """Caches compiled templates of the program, and ignores cache files that cannot be read or written."""

    def load_bytecode(self, bucket: Bucket) -> None:
        with suppress(OSError):
            super().load_bytecode(bucket)

    def dump_bytecode(self, bucket: Bucket) -> None:
        with suppress(OSError):
            super().dump_bytecode(bucket)


class TemplateProblem(Exception):
    """Raised if a template is missing, invalid, or uses an undefined name; ``diagnostic`` has the error."""

    def __init__(self, rule: str, message: str, span: Span | None = None, help: str = "") -> None:
        super().__init__(message)
        self.diagnostic = error(rule, message, span, help)


def attributes(**values: str) -> Markup:
    """Format the attributes of an XML element, each preceded by a space, with escaped values."""
    # Written in Python, because a large robot has tens of thousands of attributes, and template expressions are slow.
    text = "".join([f' {name}="{value}"' for name, value in values.items()])
    if text.count('"') != 2 * len(values) or "&" in text or "<" in text or ">" in text or "'" in text:
        text = "".join([f' {name}="{escape(value)}"' for name, value in values.items()])
    return Markup(text)  # noqa: S704 - the values are escaped


def comment(text: str) -> str:
    """Escape text for an XML comment, which must not contain two consecutive hyphens (XML 1.0, 2.5)."""
    return re.sub("-(?=-)", "- ", f"{text} " if text.endswith("-") else text)


@cache
def _own() -> jinja2.Environment:
    folder, place = data_folder("templates"), cache_folder("templates")
    loader = jinja2.FunctionLoader(lambda name: files.read_text(folder / name))
    cached = _BytecodeCache(str(place), f"{jinja2.__version__}-%s.cache") if place else None
    return jinja2.Environment(loader=loader, bytecode_cache=cached, **_OPTIONS)  # noqa: S701 - XML is escaped


class Templates:
    """Renders the Jinja templates in the folder of a description, or by default those of the program."""

    comment = staticmethod(comment)

    def __init__(self, folder: Path | None = None, first: Path | None = None, package: str = "") -> None:
        # ``first`` is the main file of the description. If it is a symlink, templates can be next to its target.
        self.folder, self.first, self.package_name = folder, first, package
        self.homes = homes(first) if first is not None else ()
        self.used: set[Path] = set()

    def read(self) -> tuple[Path, ...]:
        return tuple(sorted(file for file in self.used if any(map(file.is_relative_to, self.homes))))

    @staticmethod
    def own(name: str, values: Mapping[str, Any]) -> str:
        return _own().get_template(name).render(values)

    def package(self, name: str) -> Templates:
        return Templates(Path(import_module(name).__path__[0], "templates"), package=name)

    def render(self, name: str, values: Mapping[str, Any]) -> str:
        """Render a template. Raises TemplateProblem with the position of the error."""
        environment = jinja2.Environment(loader=jinja2.FunctionLoader(self.load), **_OPTIONS)  # noqa: S701 - is XML
        rendered = _rendered(environment, name, values) if self.package_name else self._in_child(name, values)
        for file in map(Path, rendered.inputs):
            files.record(file, files.version(file))
            self.used |= {file} if files.version(file) else set()
        rule, name, line = rendered.rule, rendered.template, rendered.line
        if not rule:
            return rendered.text
        if rule == "template-missing":
            place = f"the package {self.package_name}" if self.package_name else "the folder of the description"
            raise TemplateProblem(rule, f"there is no template {name} in {place}", None, "check the name")
        loaded = self.load(name) if line else None
        if loaded is None or self.folder is None:
            raise TemplateProblem(rule, f"{name}: {rendered.message}")
        source = Source(files.label(self.folder / name), loaded[0])
        text = source.line(line)
        span = Span(source, line, len(text) - len(text.lstrip()) + 1, max(1, len(text.strip())))
        raise TemplateProblem(rule, rendered.message, span)

    def _in_child(self, name: str, values: Mapping[str, Any]) -> _Rendered:
        import pickle  # slow to import: these three take as long as compiling a small robot
        import signal
        import subprocess

        system.needs("resource", system.NO_LIMITS)
        request = BytesIO()
        pickler = pickle.Pickler(request)
        pickler.dispatch_table = {MappingProxyType: lambda proxy: (dict, (dict(proxy),))}
        pickler.dump((self.folder, self.first, name, dict(values)))
        # Limit the threads, because the libraries of numpy reserve memory for each of them.
        env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        paths, data = json.dumps([os.path.abspath(entry) for entry in sys.path if entry]), request.getvalue()
        command = [sys.executable, "-c", _START_CHILD, paths]
        try:  # run this Python interpreter, without a shell
            done = subprocess.run(command, input=data, capture_output=True, timeout=_PATIENCE, env=env, check=False)  # noqa: S603
            if not done.returncode:
                return _Rendered(*json.loads(done.stdout))
            last = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2] or f"exit code {done.returncode}"
            killed = done.returncode in (-getattr(signal, "SIGXCPU", 0), -getattr(signal, "SIGKILL", 0))
            message = _OUT_OF_TIME if killed else f"the process that renders it ended: {last}"
        except subprocess.TimeoutExpired:
            message = f"it did not end within {_PATIENCE} s"
        return _Rendered(rule="template-failed", message=message, template=name)

    def load(self, name: str) -> tuple[str, None, Any] | None:
        if self.folder is None:
            return None
        with suppress(OSError, ValueError, RuntimeError):  # invalid file name, not UTF-8, or a cycle of symlinks
            path = files.resolve(self.folder / name)
            if any(map(path.is_relative_to, (files.resolve(self.folder), *self.homes))) and files.is_file(path):
                if path.stat().st_size > MAX_TEMPLATE:
                    raise jinja2.TemplateRuntimeError(f"it is larger than {MAX_TEMPLATE:,} bytes")
                self.used.add(path)
                return files.read_text(path), None, lambda: True
        return None


class _Rendered(NamedTuple):
    """The rendered text of a template, or the rule, message, template and line (0 if unknown) of an error."""

    text: str = ""
    rule: str = ""
    message: str = ""
    template: str = ""
    line: int = 0
    inputs: tuple[str, ...] = ()  # files that were read or searched


class _OutOfTime(BaseException):
    """Raised when the limit of the CPU time is exceeded. Not an ``Exception``, because Jinja catches these."""


def _rendered(environment: jinja2.Environment, name: str, values: Mapping[str, Any]) -> _Rendered:
    try:
        text = environment.get_template(name).render(values)
        if len(text) <= MAX_OUTPUT:
            return _Rendered(text)
        raise ValueError(f"its text has more than {MAX_OUTPUT:,} characters")
    except jinja2.TemplateSyntaxError as wrong:
        return _Rendered("", "template-syntax", wrong.message or "not a template", wrong.name or name, wrong.lineno)
    except jinja2.TemplateNotFound as missing:
        return _Rendered("", "template-missing", "", str(missing.name))
    except (Exception, _OutOfTime) as failure:  # filters of Jinja can raise any exception
        line, trace = 0, failure.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == "<template>":  # the file name of compiled templates
                template = trace.tb_frame.f_globals.get("__jinja_template__")
                # Jinja does not convert line numbers of compiled templates if the exception is _OutOfTime.
                line = template.get_corresponding_lineno(trace.tb_lineno) if template else trace.tb_lineno
            trace = trace.tb_next
        rule = "template-unsafe" if isinstance(failure, SecurityError) else "template-failed"
        message = re.sub(_INTERNAL, r"a \1", str(failure)) or type(failure).__name__
        message = "it needs too much memory" if isinstance(failure, MemoryError) else message
        return _Rendered("", rule, message, name, line)


def render_request() -> None:
    """Render a template in a child process: read the request from standard input, and print the result."""
    import pickle
    import signal

    from jinja2.sandbox import ImmutableSandboxedEnvironment

    def stop(*_: object) -> None:
        raise _OutOfTime(_OUT_OF_TIME)

    folder, first, name, values = pickle.load(sys.stdin.buffer)  # noqa: S301 - written by the parent
    with files.record_reads() as inputs:
        templates = Templates(folder, first=first)
        sandbox = ImmutableSandboxedEnvironment(loader=jinja2.FunctionLoader(templates.load), **_OPTIONS)
        del sandbox.globals["lipsum"]  # generates random text
        del sandbox.filters["random"]  # artifacts must be reproducible
        with suppress(ImportError):  # not on Windows; the parent process reports that
            import resource

            signal.signal(signal.SIGXCPU, stop)
            usage = resource.getrusage(resource.RUSAGE_SELF)
            seconds, used = int(usage.ru_utime + usage.ru_stime) + MAX_SECONDS, 300_000_000
            with suppress(OSError, ValueError):  # not Linux
                used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            memory = used + MAX_MEMORY
            # Only the hard limit interrupts a long operation in C.
            for kind, soft, hard in ((resource.RLIMIT_CPU, seconds, seconds + 1), (resource.RLIMIT_AS, memory, memory)):
                allowed = resource.getrlimit(kind)[1]
                most = hard if allowed == resource.RLIM_INFINITY else min(hard, allowed)
                resource.setrlimit(kind, (min(soft, most), most))
        rendered = _rendered(sandbox, name, values)
    places = (*templates.homes, *([files.resolve(folder)] if folder else []))
    read = sorted(os.fspath(file) for file in inputs if any(map(file.is_relative_to, places)))
    sys.stdout.buffer.write(json.dumps(rendered._replace(inputs=tuple(read))).encode())


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Render the template of an output for a robot. Raises TemplateProblem."""
    name = output.options.get("template")
    if not name:
        help = 'add "template: FILE" with a Jinja template'
        return "", [error("template-not-named", f'output "{output.name}" has no template', None, help)]
    values = {"robot": robot, "output": output, "number": short, "exact": exact, "six": six, "fixed": to_fixed}
    values |= {"degrees": math.degrees, "radians": math.radians, "source": describe, "vector": vector}
    values["kind"] = attrgetter("__class__.__name__")  # class name of a geometry, such as Box
    return templates.render(name, values), []


_TEMPLATE = "Jinja template in the folder of the description, for a custom artifact."
FORMAT = Format(
    name="template",
    word="artifact of a template",
    article="an",
    rank=900,
    options={
        "template": {"type": "string", "description": _TEMPLATE},
        "options": {"type": "object", "description": "Custom values, available as output.options.options."},
    },
    write=write,
)
