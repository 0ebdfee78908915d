"""The templates that ship with the tool, compiled ahead of time: Jinja makes Python of them, which runs without Jinja.

Importing Jinja takes longer than rendering all of them. What its Python asks for at run time is little and stands here.
When a wheel is built, each template of a format becomes a module beside the templates (``setup.py``). In a checkout
there are none: there the Python is made when a template is first used, and kept as text in the user's cache.

``records_of`` is what a wheel knows of formats, so that those that nobody uses are not imported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from importlib import import_module
from types import CodeType
from typing import TYPE_CHECKING, Any, NoReturn

from ..project import data_folder
from ..startup import patterns
from ..startup.cache import cache_folder, digest, keep, recalled
from ..xml.escaping import Markup, escape

if TYPE_CHECKING:
    from .format import Format

FOLDER = "ahead"
XML = (".urdf", ".xml", ".sdf", ".svg", ".html", ".launch", ".srdf", ".xacro")

# The first line of what Jinja makes, and what stands in its place.
_IMPORT = "from jinja2.runtime import "
_OWN = f"from {__name__} import Undefined, environment, escape, missing, str_join\n"
# What it may ask for; what no filter of that name leads to (the last two) is never reached.
_ASKED = frozenset(
    f"{__name__} name root blocks debug_info environment Undefined escape missing str_join str KeyError "
    "resolve_or_missing undefined concat filters getattr getitem call eval_ctx save revert autoescape "
    "internalcode TemplateRuntimeError".split()
)
_FILTER = patterns.compile(r"environment\.filters\['(\w+)'\]")


class Unsuited(Exception):
    """A template asks for more than there is without Jinja."""


missing = object()
str_join = "".join


def Undefined(*_: object, name: str) -> NoReturn:  # noqa: N802 - a name of Jinja
    """Raise LookupError: a template asks for a value that it was not given, which is a mistake of the tool."""
    raise LookupError(f"'{name}' is undefined")


class _Evaluation:
    """Whether what is printed is escaped, as ``{% autoescape %}`` changes it."""

    def __init__(self, autoescape: bool) -> None:
        self.autoescape = autoescape

    def save(self) -> bool:
        return self.autoescape

    def revert(self, before: bool) -> None:
        self.autoescape = before


class _Context:
    """The values of one rendering."""

    def __init__(self, values: Mapping[str, Any], autoescape: bool) -> None:
        self.values = values
        self.eval_ctx = _Evaluation(autoescape)

    def resolve_or_missing(self, name: str) -> Any:
        return self.values.get(name, missing)

    def call(self, function: Callable[..., Any], *values: Any, _loop_vars: object = None, **named: Any) -> Any:
        return function(*values, **named)


def _indent(text: str, width: int) -> str:
    """Return a text whose lines after the first are moved to the right, but for empty ones."""
    first, *rest = text.split("\n")
    return "\n".join([first, *(" " * width + line if line else line for line in rest)])


class _Environment:
    """What stands for the environment of Jinja."""

    undefined = staticmethod(Undefined)
    concat = staticmethod("".join)
    getattr = staticmethod(getattr)
    filters: Mapping[str, Callable[..., Any]] = {"safe": Markup, "e": escape, "length": len, "indent": _indent}

    @staticmethod
    def getitem(value: Any, key: Any) -> Any:
        return value[key]


environment = _Environment()


def render(name: str, values: Mapping[str, Any]) -> str:
    """Return the text of a template that ships with the tool ("robot.urdf.jinja")."""
    return "".join(_root(name)(_Context(values, is_xml(name))))


def is_xml(name: str | None) -> bool:
    """Say whether what a template makes is XML, by its name; that is escaped."""
    return (name or "").removesuffix(".jinja").endswith(XML)


def module_of(name: str) -> str:
    """Return the name of the module that a template becomes."""
    return name.removesuffix(".jinja").replace(".", "_")


@cache
def _root(name: str) -> Callable[[_Context], Any]:
    """Return the function that a template is made into."""
    try:
        made = vars(import_module(f"rosorin_compile.templates.{FOLDER}.{module_of(name)}"))
    except ModuleNotFoundError:
        made = {"__name__": name}
        exec(_kept(name), made)  # noqa: S102 - what Jinja made of our own template
    root: Callable[..., Any] = made["root"]
    return root


def _kept(name: str) -> CodeType:
    """Return the code of a template, of the Python in the cache if that was made of this very template."""
    source = (data_folder("templates") / name).read_text("utf-8")
    folder = cache_folder("templates")
    if folder is None:
        return compile(python_of(name, source), f"<{name}>", "exec")
    file = folder / f"{digest(repr((_OWN, name, source)).encode())}.py"
    made = recalled(file)
    if made is None:
        made = python_of(name, source).encode()
        keep(file, made)
    return compile(made.decode(), f"<{name}>", "exec")


def python_of(name: str, source: str) -> str:
    """Return the Python of a template. Raises Unsuited."""
    import jinja2

    options: dict[str, Any] = {"trim_blocks": True, "lstrip_blocks": True, "keep_trailing_newline": True}
    jinja = jinja2.Environment(autoescape=is_xml, undefined=jinja2.StrictUndefined, **options)  # noqa: S701
    made: str = jinja.compile(source, name, raw=True)
    text = "".join(_OWN if line.startswith(_IMPORT) else line for line in made.splitlines(keepends=True))
    more = (_names(compile(text, name, "exec")) - _ASKED) | (set(_FILTER.findall(text)) - set(_Environment.filters))
    if more:
        raise Unsuited(f"the template {name} asks for {', '.join(sorted(more))}")
    return text


def _names(code: CodeType) -> set[str]:
    """Return the global names and attributes that code asks for."""
    inner = [_names(one) for one in code.co_consts if isinstance(one, CodeType)]
    return set(code.co_names).union(*inner)


def records_of(formats: Iterable[Format]) -> str:
    """Return the text of the module: of each format what is plain in its record, and which functions it has."""
    lines = []
    for one in formats:
        functions = sorted(name for name, value in vars(one).items() if callable(value))
        plain = {name: value for name, value in vars(one).items() if name not in functions and value is not None}
        said = ", ".join(f"{name!r}: {_text(value)}" for name, value in plain.items())
        lines.append(f"    ({{{said}}}, {functions}),\n")
    return f"RECORDS = [\n{''.join(lines)}]\n"


def _text(value: Any) -> str:
    """Return a value as Python reads it, the same each time."""
    return f"frozenset({sorted(value)})" if isinstance(value, frozenset) else repr(value)
