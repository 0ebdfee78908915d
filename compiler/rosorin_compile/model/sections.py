"""Sections of descriptions, built-in or of plug-ins, and the values of plug-in sections."""

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
Given = Schema | None  # None reads schema.json next to the module of the dataclass
Adds = Callable[["Robot", Any], "Robot"]
Lower = Callable[[Mapping[str, Any], Any], Any]  # takes the tree and a function that reports problems

# Packages with a folder for each built-in section; the tuple ``SECTIONS`` of a package lists the sections.
PACKAGES = ("rosorin_compile.language.sections", "rosorin_compile.ros.sections", "rosorin_compile.mujoco.sections")

ENTRIES, ITEMS, ONE = "entries", "items", "one"


@dataclass(frozen=True, eq=False)
class Section(Generic[T]):
    """A section of descriptions: its schema, the dataclass of an entry, its rules and its conversion.

    A plug-in calls ``by_name`` (many entries by name), ``listed`` (a list) or ``single`` (one entry, or None), with
    ``adds``, ``checks`` and ``lower`` as keywords.
    """

    name: str
    entry: type[Any] = object  # a dataclass with a field (in SI units) per key; a ``Pose`` is for ``xyz`` and ``rpy``
    schema: Schema = field(default_factory=dict)  # JSON Schema draft 7 with annotations (docs/extend.md)
    form: str = ENTRIES
    adds: Adds | None = None  # returns the robot with what the section adds, such as links
    checks: tuple[Check | str, ...] = ()  # functions with ``@rule``, or names of their modules
    lower: Lower | None = None  # custom conversion (tree, problem) -> value; problem(rule, message, path, help)
    # Built-in only: return (and check) XML elements for a URDF output that has an option named after the section.
    urdf: Callable[[Robot, Output, NumberFormat], list[str]] | None = None
    check_urdf: Callable[[Case, Output], Iterator[Diagnostic]] | None = None

    @classmethod
    def by_name(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[Mapping[str, Entry]]:
        return Section(name, entry, schema or _schema_of(entry), ENTRIES, **more)

    @classmethod
    def listed(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[tuple[Entry, ...]]:
        return Section(name, entry, schema or _schema_of(entry), ITEMS, **more)

    @classmethod
    def single(cls, name: str, entry: type[Entry], schema: Given = None, **more: Any) -> Section[Entry | None]:
        return Section(name, entry, schema or _schema_of(entry), ONE, **more)

    def all_checks(self) -> tuple[Check, ...]:
        """Return the functions in ``checks`` and in the modules that it names."""
        named = (checks_of(import_module(one)) if isinstance(one, str) else (one,) for one in self.checks)
        return tuple(check for checks in named for check in checks)

    def check(self) -> None:
        """Raise ValueError or TypeError if schema or entry type do not match ``form`` (entries, items or one)."""
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
    """Import and return the built-in sections, in the order in which they are converted."""
    return tuple(section for package in PACKAGES for section in import_module(package).SECTIONS)


def sections_in_urdf(output: Output) -> list[Section[Any]]:
    """Return the sections that add elements to a URDF, according to the options of its output."""
    return [section for section in own_sections() if section.urdf is not None and output.options.get(section.name)]


@dataclass(frozen=True)
class Sections:
    """The values of plug-in sections by name."""

    values: Mapping[str, Any] = field(default_factory=dict)
    said: Mapping[str, Any] = field(default_factory=dict)  # sections as plain values in SI units, with schema defaults
    # The robot before ``adds`` of its sections, or None if they add nothing.
    without: Robot | None = field(default=None, compare=False, repr=False)

    @overload
    def __getitem__(self, section: Section[T]) -> T: ...

    @overload
    def __getitem__(self, section: str) -> Any: ...

    def __getitem__(self, section: Section[Any] | str) -> Any:
        # If the robot lacks the section, a ``Section`` returns an empty value, but a name raises KeyError.
        empty: dict[str, Any] = {ENTRIES: {}, ITEMS: (), ONE: None}
        return self.values[section] if isinstance(section, str) else self.values.get(section.name, empty[section.form])

    def __contains__(self, section: object) -> bool:
        return getattr(section, "name", section) in self.values
