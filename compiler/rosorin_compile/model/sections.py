"""Sections of descriptions, built-in or from plug-ins, and the values of plug-in sections."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from rosorin_compile.source.rule_registry import Check, checks_of

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.numbers import NumberFormat

    from .robot import Output, Robot

T = TypeVar("T")
Entry = TypeVar("Entry")
Schema = Mapping[str, Any]
Given = Schema | None  # None: read schema.json from the folder of the dataclass
Adds = Callable[["Robot", Any], "Robot"]
Lower = Callable[[Mapping[str, Any], Any], Any]  # (YAML tree of the section, function that reports a problem) -> value

# Packages with a folder for each built-in section. Each package lists its sections in the tuple ``SECTIONS``.
PACKAGES = ("rosorin_compile.language.sections", "rosorin_compile.ros.sections", "rosorin_compile.mujoco.sections")

ENTRIES, ITEMS, ONE = "entries", "items", "one"


@dataclass(frozen=True, eq=False)
class Section(Generic[T]):
    """A section of descriptions: its schema, the dataclass of its entries, its rules and its conversion.

    Plug-ins create it with ``by_name`` (a mapping of entries), ``listed`` (a list of entries) or ``single`` (an entry
    or None). The keyword arguments are ``adds``, ``checks`` and ``lower``.
    """

    name: str
    entry: type[Any] = object  # dataclass: a field (SI units) for each key, a ``Pose`` for ``xyz`` with ``rpy``
    schema: Schema = field(default_factory=dict)  # JSON Schema draft 7 with annotations (docs/extend.md)
    form: str = ENTRIES  # ENTRIES, ITEMS or ONE
    adds: Adds | None = None  # returns a robot with additions, such as links, from the value of the section
    checks: tuple[Check | str, ...] = ()  # functions with ``@rule``, or names of modules with such functions
    lower: Lower | None = None  # lower(tree, problem) -> value; call problem(rule, message, path, help) for an error
    # For built-in sections: functions that return and check XML elements for URDF outputs with the option ``name``.
    urdf: Callable[[Robot, Output, NumberFormat], list[str]] | None = None
    check_urdf: Callable[[Case, Output], Iterator[Diagnostic]] | None = None

    @classmethod
    def by_name(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[Mapping[str, Entry]]:
        return Section(name, entry, schema or _schema_of(entry), ENTRIES, **more)

    @classmethod
    def list_of(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[tuple[Entry, ...]]:
        return Section(name, entry, schema or _schema_of(entry), ITEMS, **more)

    @classmethod
    def single(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[Entry | None]:
        return Section(name, entry, schema or _schema_of(entry), ONE, **more)

    def all_checks(self) -> tuple[Check, ...]:
        """Return all check functions, including those in the modules that ``checks`` names."""
        named = (checks_of(import_module(one)) if isinstance(one, str) else (one,) for one in self.checks)
        return tuple(check for checks in named for check in checks)

    def check(self) -> None:
        """Raise ValueError or TypeError if the name, the dataclass or the schema of the section is invalid."""
        if not (isinstance(self.name, str) and self.name.isidentifier() and self.name == self.name.lower()):
            raise ValueError(f'"{self.name}" cannot be the name of a section: small letters, digits and _')
        if not (isinstance(self.entry, type) and is_dataclass(self.entry)):
            raise TypeError(f"the entry of section {self.name} is {str(self.entry)[:60]!r}, not a dataclass")
        form = ITEMS if "items" in self.schema else ONE
        form = ENTRIES if isinstance(self.schema.get("additionalProperties"), Mapping) else form
        if form != self.form:
            raise ValueError(f"the schema of section {self.name} is of {form}, its record of {self.form}")


def _schema_of(entry: type[Any]) -> Any:
    return json.loads(Path(inspect.getfile(entry)).with_name("schema.json").read_text("utf-8"))


@cache
def own_sections() -> tuple[Section[Any], ...]:
    """Import the built-in sections and return them in the order in which they are converted."""
    return tuple(section for package in PACKAGES for section in import_module(package).SECTIONS)


def sections_in_urdf(output: Output) -> list[Section[Any]]:
    """Return the built-in sections that add XML elements to a URDF output, according to its options."""
    return [section for section in own_sections() if section.urdf is not None and output.options.get(section.name)]


@dataclass(frozen=True)
class Sections:
    """The values of plug-in sections by name."""

    values: Mapping[str, Any] = field(default_factory=dict)
    said: Mapping[str, Any] = field(default_factory=dict)  # plain values in SI units, with schema defaults, by section
    # The robot without the additions of its sections, or None if they add nothing.
    without: Robot | None = field(default=None, compare=False, repr=False)

    @overload
    def __getitem__(self, section: Section[T]) -> T: ...

    @overload
    def __getitem__(self, section: str) -> Any: ...

    def __getitem__(self, section: Section[Any] | str) -> Any:
        # If the robot lacks the section, return an empty value for a ``Section``, and raise KeyError for a name.
        empty: dict[str, Any] = {ENTRIES: {}, ITEMS: (), ONE: None}
        return self.values[section] if isinstance(section, str) else self.values.get(section.name, empty[section.form])

    def __contains__(self, section: object) -> bool:
        return getattr(section, "name", section) in self.values
