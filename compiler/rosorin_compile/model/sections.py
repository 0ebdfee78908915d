"""Sections of the language that are defined outside the core: by a plug-in, or by the folders for ROS and MuJoCo."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, is_dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.numbers import NumberFormat
    from rosorin_compile.source.rule_registry import Check

    from .robot import Output, Robot

T = TypeVar("T")
Entry = TypeVar("Entry")
Adds = Callable[["Robot", Any], "Robot"]
Lower = Callable[[Mapping[str, Any], Any], Any]  # of the tree, and of what reports a problem (``Problem``)

# The module of each section of the tool that is not defined in the core; the record has its name in capitals. A value
# is the field of ``Robot`` with the name of the section.
SECTIONS = {
    "control": "rosorin_compile.ros.sections.control",
    "controllers": "rosorin_compile.ros.sections.controllers",
    "moveit": "rosorin_compile.ros.sections.moveit",
    "actuators": "rosorin_compile.mujoco.sections.simulation",
    "constraints": "rosorin_compile.mujoco.sections.simulation",
}

ENTRIES, ITEMS, ONE = "entries", "items", "one"


@dataclass(frozen=True, eq=False)
class Section(Generic[T]):
    """A section of descriptions: its schema, the dataclass of its entries, its rules and its conversion.

    The tool and plug-ins define sections in the same way; a plug-in calls ``by_name``, ``listed`` or ``single``.

    ``entry`` is the dataclass of one entry: each field is the key of its name, in SI units; ``name`` is that of an
    entry by name, and a field of type ``Pose`` is made of ``xyz`` and ``rpy``. ``schema`` is the piece of the schema of
    descriptions: JSON Schema of draft 7, which may refer to the definitions of ours, with the annotations of
    docs/extend.md; the sections of the tool are in ``schemas/description.schema.json``. ``checks`` are functions under
    ``@rule``. ``lower`` converts the whole tree to the value of the section where the fields of the dataclass are not
    enough; it gets the tree and ``problem(rule, message, path, help)``. ``adds`` returns the robot with what the
    section means for it: a mass, shapes, links that are fixed, elements; it gets the robot and the value.

    Only of the tool: ``urdf`` returns elements for a URDF whose output has an option with the name of the section, and
    ``check_urdf`` validates them.
    """

    name: str
    entry: type[Any] = object
    schema: Mapping[str, Any] = field(default_factory=dict)
    form: str = ENTRIES
    adds: Adds | None = None
    checks: tuple[Check, ...] = ()
    lower: Lower | None = None
    urdf: Callable[[Robot, Output, NumberFormat], list[str]] | None = None
    check_urdf: Callable[[Case, Output], Iterator[Diagnostic]] | None = None

    @classmethod
    def by_name(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, Mapping[str, Entry]], Robot] | None = None,
        checks: tuple[Check, ...] = (),
        lower: Lower | None = None,
    ) -> Section[Mapping[str, Entry]]:
        """Return a section of many entries by name."""
        return Section(name, entry, schema, ENTRIES, adds, checks, lower)

    @classmethod
    def listed(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, tuple[Entry, ...]], Robot] | None = None,
        checks: tuple[Check, ...] = (),
        lower: Lower | None = None,
    ) -> Section[tuple[Entry, ...]]:
        """Return a section that is a list of entries."""
        return Section(name, entry, schema, ITEMS, adds, checks, lower)

    @classmethod
    def single(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, Entry], Robot] | None = None,
        checks: tuple[Check, ...] = (),
        lower: Lower | None = None,
    ) -> Section[Entry | None]:
        """Return a section that is one entry; None is the value where a robot does not have it."""
        return Section(name, entry, schema, ONE, adds, checks, lower)

    def empty(self) -> Any:
        """Return the value of a section that is not there."""
        return {ENTRIES: {}, ITEMS: (), ONE: None}[self.form]

    def check(self) -> None:
        """Raise ValueError or TypeError for an invalid record: a schema of another form, fields without a key."""
        if not (isinstance(self.name, str) and self.name.isidentifier() and self.name == self.name.lower()):
            raise ValueError(f'"{self.name}" cannot be the name of a section: small letters, digits and _')
        if not (isinstance(self.entry, type) and is_dataclass(self.entry)):
            raise TypeError(f"the entry of section {self.name} is {str(self.entry)[:60]!r}, not a dataclass")
        if not isinstance(self.schema, Mapping) or not isinstance(self.checks, tuple):
            raise TypeError(f"the schema of section {self.name} is a mapping, its checks are a tuple")
        for key in ("adds", "lower"):
            if getattr(self, key) is not None and not callable(getattr(self, key)):
                raise TypeError(f"{key} of section {self.name} is a function")
        for key in ("urdf", "check_urdf"):
            if getattr(self, key) is not None:
                raise TypeError(f"section {self.name} has {key}, which only sections of the tool itself have")
        form = _form_of(self.schema)
        if form != self.form:
            raise ValueError(f"the schema of section {self.name} says {_WORDS[form]}, its record {_WORDS[self.form]}")


def _form_of(schema: Mapping[str, Any]) -> str:
    """Return the form of the section that a piece of the schema is for."""
    if isinstance(schema.get("additionalProperties"), Mapping):
        return ENTRIES
    return ITEMS if "items" in schema else ONE


_WORDS = {ENTRIES: "many entries by name", ITEMS: "a list of entries", ONE: "one entry"}


@cache
def section_named(name: str) -> Section[Any]:
    """Return the record of a section in ``SECTIONS``; imports its module."""
    record: Section[Any] = getattr(import_module(SECTIONS[name]), name.upper())
    return record


def own_sections() -> Iterator[Section[Any]]:
    """Yield the records of all sections in ``SECTIONS``."""
    return map(section_named, SECTIONS)


def sections_in_urdf(output: Output) -> Iterator[Section[Any]]:
    """Yield the sections of which a URDF has elements: those that the options of its output name."""
    for name in SECTIONS:
        if output.options.get(name) and section_named(name).urdf is not None:
            yield section_named(name)


@dataclass(frozen=True)
class Sections:
    """The values of sections of plug-ins, and what of the robot is theirs.

    ``values`` are by name; ``said`` is what the description says there, as plain lists, mappings, texts and numbers in
    SI units, with the defaults of the schema. ``without`` is the robot without what its sections add; None: the same.
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    said: Mapping[str, Any] = field(default_factory=dict)
    without: Robot | None = field(default=None, compare=False, repr=False)

    @overload
    def __getitem__(self, section: Section[T]) -> T: ...

    @overload
    def __getitem__(self, section: str) -> Any: ...

    def __getitem__(self, section: Section[Any] | str) -> Any:
        """Return the value of a section; an empty one if the robot does not have it.

        Raises KeyError for the name of a section that the robot does not have.
        """
        return self.values[section] if isinstance(section, str) else self.values.get(section.name, section.empty())

    def __contains__(self, section: object) -> bool:
        """Return True if the robot has a section, given by its record or its name."""
        return getattr(section, "name", section) in self.values


NO_SECTIONS = Sections()
