"""The sandbox of templates: Jinja's, with a short way to the model, and with bounds on what a template may make.

Whatever a template asks for ends soon or fails: texts, lists and numbers have a largest size, and all
``range`` of one rendering together a largest length. ``options`` are those of all templates, the tool's own among them.
"""

from __future__ import annotations

import marshal
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from jinja2 import BytecodeCache, StrictUndefined, TemplateRuntimeError, nodes
from jinja2 import __version__ as jinja_version
from jinja2.bccache import Bucket
from jinja2.compiler import CodeGenerator, Frame
from jinja2.sandbox import ImmutableSandboxedEnvironment

from rosorin_compile.source.cache import cache_folder, digest, keep, recalled

MAX_SIZE = 10_000_000  # letters of a text, items of a list
MAX_BITS = 1_000_000  # of a whole number
MAX_ROUNDS = 1_000_000  # of all ranges of one rendering
_WIDTH = re.compile(r"\d{5,}")
# Filters whose argument is a number of letters or items that they make.
_FILLING = ("batch", "center", "indent", "slice", "wordwrap")
_MODEL = ("rosorin_compile.model.", "rosorin_compile.formats.")
_XML = (".urdf", ".xml", ".sdf", ".svg", ".html", ".launch", ".srdf", ".xacro")


def _is_xml(name: str | None) -> bool:
    """Say whether what a template makes is XML, by its name; that is escaped."""
    return (name or "").removesuffix(".jinja").endswith(_XML)


class _Bytecode(BytecodeCache):
    """Keeps the code of templates in the user's cache, by all that it is made of: Jinja takes its time over it."""

    def __init__(self) -> None:
        self.folder = cache_folder("templates")
        self.made_by = jinja_version, sys.version, digest(Path(__file__).read_bytes())

    def get_cache_key(self, name: str, filename: str | None = None) -> str:
        return repr((name, filename))  # Jinja's has no answer to a name that is no UTF-8

    def load_bytecode(self, bucket: Bucket) -> None:
        kept = recalled(self._file(bucket)) if self.folder else None
        if kept is not None:
            bucket.code = marshal.loads(kept)  # noqa: S302 - only the user can write there

    def dump_bytecode(self, bucket: Bucket) -> None:
        if self.folder:
            keep(self._file(bucket), marshal.dumps(bucket.code))

    def _file(self, bucket: Bucket) -> Path:
        means = *self.made_by, type(bucket.environment).__name__, bucket.key, bucket.checksum
        return Path(self.folder or "", digest(repr(means).encode()))


def options() -> dict[str, Any]:
    """Return the options of Jinja for all templates."""
    blocks = {"trim_blocks": True, "lstrip_blocks": True, "keep_trailing_newline": True}
    return {"autoescape": _is_xml, "undefined": StrictUndefined, "bytecode_cache": _Bytecode(), **blocks}


class _Code(CodeGenerator):
    """Jinja's, with a bound on what ``~`` makes: a text that is doubled again and again."""

    def visit_Concat(self, node: nodes.Concat, frame: Frame) -> None:  # noqa: N802 - a name of Jinja
        self.write("environment.bounded(")
        super().visit_Concat(node, frame)
        self.write(")")


class Sandbox(ImmutableSandboxedEnvironment):
    """The sandbox; ``begin`` is called before each rendering.

    The model is frozen values whose public attributes and methods are harmless, so Jinja's long check of each access is
    spared; a name that begins with an underscore, and every other object, goes the long way.
    """

    intercepted_binops = frozenset(("+", "*", "**", "%"))
    code_generator_class = _Code

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.harmless: dict[type, bool] = {}
        self.rounds = 0
        self.globals["range"] = self.range
        del self.globals["lipsum"]  # text that nobody needs in an artifact, as much as is asked for
        del self.filters["random"]  # an artifact is the same each time
        for name in _FILLING:
            self.filters[name] = _narrow(self.filters[name])
        self.filters["format"] = _format

    def begin(self) -> None:
        """Begin a rendering."""
        self.rounds = 0

    def range(self, *bounds: int) -> range:
        """Return a range. Raises TemplateRuntimeError when all of them together get too long."""
        numbers = range(*bounds)
        self.rounds += len(numbers)
        if self.rounds > MAX_ROUNDS:
            raise TemplateRuntimeError(f"its ranges have more than {MAX_ROUNDS:,} numbers together")
        return numbers

    def getattr(self, obj: Any, attribute: str) -> Any:
        """Return an attribute, of the model without Jinja's long check."""
        kind = type(obj)
        harmless = self.harmless.get(kind)
        if harmless is None:
            harmless = self.harmless[kind] = kind.__module__.startswith(_MODEL)
        if harmless and not attribute.startswith("_"):
            try:
                return getattr(obj, attribute)
            except AttributeError:
                pass
        return super().getattr(obj, attribute)

    def call_binop(self, context: Any, operator: str, left: Any, right: Any) -> Any:
        """Return the value of an operator that could make something huge. Raises TemplateRuntimeError for that."""
        if operator == "+":
            if isinstance(left, (str, bytes, list, tuple)) and isinstance(right, type(left)):
                _check_size(len(left) + len(right))
        elif operator == "*":
            for many, times in ((left, right), (right, left)):
                if isinstance(many, (str, bytes, list, tuple)) and isinstance(times, int):
                    _check_size(len(many) * times)
        elif operator == "**" and isinstance(left, int) and isinstance(right, int):
            if left.bit_length() * right > MAX_BITS:
                raise TemplateRuntimeError(f"a number of more than {MAX_BITS:,} bits")
        elif operator == "%" and isinstance(left, str):
            return _format(left, right)
        return super().call_binop(context, operator, left, right)

    def bounded(self, text: str) -> str:
        """Return a joined text. Raises TemplateRuntimeError for one that is very long."""
        _check_size(len(text))
        return text

    def wrap_str_format(self, value: Any) -> Callable[..., str] | None:
        """Return a safe ``format`` for that of a text. Raises TemplateRuntimeError for a text that is very wide."""
        wrapped = super().wrap_str_format(value)
        if wrapped is not None:
            _check_width(getattr(value, "__self__", ""))
        return wrapped

    def call(self, context: Any, function: Any, /, *values: Any, **named: Any) -> Any:
        """Call something. Raises TemplateRuntimeError for a text that is told to be very wide."""
        if getattr(function, "__name__", "") in ("center", "ljust", "rjust", "zfill"):
            _check_width(*values, *named.values())
        return super().call(context, function, *values, **named)


def _check_size(size: int) -> None:
    if size > MAX_SIZE:
        raise TemplateRuntimeError(f"a text or list of more than {MAX_SIZE:,} letters or items")


def _check_width(*values: Any) -> None:
    for value in values:
        if isinstance(value, str) and _WIDTH.search(value):
            raise TemplateRuntimeError("a width of more than 9,999 letters")
        if isinstance(value, int) and abs(value) > MAX_SIZE:
            raise TemplateRuntimeError(f"a number of more than {MAX_SIZE:,} letters or items")


def _narrow(fill: Callable[..., Any]) -> Callable[..., Any]:
    """Return a filter that refuses to make something huge."""

    def narrow(*given: Any, **named: Any) -> Any:
        _check_width(*(value for value in (*given, *named.values()) if isinstance(value, int)))
        return fill(*given, **named)

    # What Jinja notes on a function, such as that it wants the environment first.
    vars(narrow).update(vars(fill))
    return narrow


def _format(text: str, *values: Any, **named: Any) -> Any:
    """Return a text with its percent signs filled in."""
    given = values[0] if len(values) == 1 and isinstance(values[0], (tuple, dict)) else named or values
    _check_width(text, *(given if isinstance(given, tuple) else ()))
    return text % given
