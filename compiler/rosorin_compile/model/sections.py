"""Sections: words of the language that a package brings (``Section``), and what a robot says in them (``Sections``)."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, is_dataclass, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from rosorin_compile.source import files

if TYPE_CHECKING:
    from rosorin_compile.source.rule_registry import Check

    from .robot import Robot

T = TypeVar("T")
Entry = TypeVar("Entry")
Adds = Callable[["Robot", Any], "Robot"]

# The module and the name of the record of each section that has a folder.
SECTIONS = (
    "rosorin_compile.language.sections.servos:SERVOS",
    "rosorin_compile.language.sections.drive:DRIVE",
    "rosorin_compile.ros.sections.control:CONTROL",
    "rosorin_compile.ros.sections.controllers:CONTROLLERS",
    "rosorin_compile.ros.sections.moveit:MOVEIT",
    "rosorin_compile.language.sections.disabled_contacts:DISABLED_CONTACTS",
    "rosorin_compile.mujoco.sections.simulation:ACTUATORS",
    "rosorin_compile.mujoco.sections.simulation:TENDONS",
    "rosorin_compile.mujoco.sections.simulation:CONSTRAINTS",
    "rosorin_compile.mujoco.sections.simulation:MJCF_SENSORS",
    "rosorin_compile.mujoco.sections.simulation:CONTACT_LAYERS",
    "rosorin_compile.mujoco.sections.simulation:CONTACT_PAIRS",
    "rosorin_compile.language.sections.mjcf_elements:MJCF_ELEMENTS",
)

ENTRIES, ITEMS, ONE = "entries", "items", "one"


@dataclass(frozen=True, eq=False)
class Section(Generic[T]):
    """A section of descriptions. Made by ``by_name``, ``listed`` or ``single``, which say what ``Sections`` has of it.

    ``entry`` is the dataclass of one entry: each field is the key of its name, in SI units; ``name`` is that of an
    entry by name, and a field of type ``Pose`` is made of ``xyz`` and ``rpy``. ``schema`` is the piece of the schema of
    descriptions: JSON Schema of draft 7, which may refer to the definitions of ours, with the annotations of
    docs/extend.md. ``adds`` returns the robot with what the section means for it: a mass, shapes, links that are
    fixed, elements; it gets the robot and the value. ``checks`` are functions under ``@rule``.
    """

    name: str
    entry: type[Any]
    schema: Mapping[str, Any]
    form: str
    adds: Adds | None = None
    checks: tuple[Check, ...] = ()

    @classmethod
    def by_name(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, Mapping[str, Entry]], Robot] | None = None,
        checks: tuple[Check, ...] = (),
    ) -> Section[Mapping[str, Entry]]:
        """Return a section of many entries by name."""
        return Section(name, entry, schema, ENTRIES, adds, checks)

    @classmethod
    def listed(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, tuple[Entry, ...]], Robot] | None = None,
        checks: tuple[Check, ...] = (),
    ) -> Section[tuple[Entry, ...]]:
        """Return a section that is a list of entries."""
        return Section(name, entry, schema, ITEMS, adds, checks)

    @classmethod
    def single(
        cls,
        name: str,
        entry: type[Entry],
        schema: Mapping[str, Any],
        *,
        adds: Callable[[Robot, Entry], Robot] | None = None,
        checks: tuple[Check, ...] = (),
    ) -> Section[Entry | None]:
        """Return a section that is one entry; None is the value where a robot does not have it."""
        return Section(name, entry, schema, ONE, adds, checks)

    def empty(self) -> Any:
        """Return the value of a section that is not there."""
        return {ENTRIES: {}, ITEMS: (), ONE: None}[self.form]

    def check(self) -> None:
        """Raise ValueError or TypeError for a record that is none: a schema of another form, fields without a key."""
        if not (isinstance(self.name, str) and self.name.isidentifier() and self.name == self.name.lower()):
            raise ValueError(f'"{self.name}" cannot be the name of a section: small letters, digits and _')
        if not (isinstance(self.entry, type) and is_dataclass(self.entry)):
            raise TypeError(f"the entry of section {self.name} is {str(self.entry)[:60]!r}, not a dataclass")
        if not isinstance(self.schema, Mapping) or not isinstance(self.checks, tuple):
            raise TypeError(f"the schema of section {self.name} is a mapping, its checks are a tuple")
        if self.adds is not None and not callable(self.adds):
            raise TypeError(f"adds of section {self.name} is a function")
        form = _form_of(self.schema)
        if form != self.form:
            raise ValueError(f"the schema of section {self.name} says {_WORDS[form]}, its record {_WORDS[self.form]}")


def _form_of(schema: Mapping[str, Any]) -> str:
    """Return the form of the section that a piece of the schema is for."""
    if isinstance(schema.get("additionalProperties"), Mapping):
        return ENTRIES
    return ITEMS if "items" in schema else ONE


_WORDS = {ENTRIES: "many entries by name", ITEMS: "a list of entries", ONE: "one entry"}


@dataclass(frozen=True, eq=False)
class OwnSection(Section[T]):
    """A section that stands in a folder of the tool itself, made by ``in_folder``.

    ``nothing`` is its value where a robot does not have it, ``after`` the section that it stands behind in the schema.
    What needs a function is in a module of the folder, and named as text: ``lowers`` makes the value of the tree,
    ``compares`` yields what differs between two robots (``meaning.others``), or ``tells`` returns what is said, by what
    it is called, for the comparison of its topic (``meaning.simulation``); ``rules`` is the module of its rules. What a
    URDF has of it, if an output says so under the name of the section: ``in_urdf`` returns elements of the robot, by
    the robot, the output and how numbers are printed, and ``checks_urdf`` yields what is wrong with them.
    """

    nothing: Any = None
    after: str = ""
    lowers: str = ""
    compares: str = ""
    tells: str = ""
    rules: str = ""
    in_urdf: str = ""
    checks_urdf: str = ""
    package: str = ""

    @classmethod
    def in_folder(
        cls,
        package: str,
        folder: str,
        nothing: T,
        *,
        after: str,
        lowers: str,
        compares: str = "",
        tells: str = "",
        rules: str = "",
        in_urdf: str = "",
        checks_urdf: str = "",
        name: str = "",
    ) -> OwnSection[T]:
        """Return the section whose folder is a package; it is called as that, and has its piece of the schema there.

        One of several that share a folder says its ``name``, and has its piece in NAME.json.
        """
        schema: Mapping[str, Any] = json.loads(files.read_text(Path(folder) / f"{name or 'schema'}.json"))
        name = name or package.rpartition(".")[2]
        made: OwnSection[T] = OwnSection(name, object, schema, _form_of(schema), nothing=nothing, after=after)
        functions: dict[str, Any] = {"lowers": lowers, "compares": compares, "tells": tells, "rules": rules}
        functions |= {"in_urdf": in_urdf, "checks_urdf": checks_urdf}
        return replace(made, package=package, **functions)

    def empty(self) -> Any:
        """Return the value of a section that is not there."""
        return self.nothing

    def function(self, named: str) -> Any:
        """Return a function of its package, which is named MODULE:FUNCTION."""
        return getattr(self.module(named), named.partition(":")[2])

    def module(self, named: str) -> ModuleType:
        """Return a module of its package, or that of a function there."""
        return import_module(f".{named.partition(':')[0]}", self.package)


@cache
def own_sections() -> Mapping[str, OwnSection[Any]]:
    """Return the sections of the tool itself that stand in folders of their own, by name."""
    found = (name.partition(":") for name in SECTIONS)
    records = (getattr(import_module(module), record) for module, _, record in found)
    return {one.name: one for one in records}


@cache
def own_families() -> Mapping[str, Callable[[Robot], Any]]:
    """Return what gathers the values of sections that share a folder, by the name of the folder."""
    packages = {one.package: import_module(one.package) for one in own_sections().values()}
    return {name.rpartition(".")[2]: one.gathered for name, one in packages.items() if hasattr(one, "gathered")}


@dataclass(frozen=True)
class Sections:
    """The values of sections, and what of the robot is theirs.

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
        """Return the value of a section, or of the one of a name; of one that the robot does not have, an empty one.

        Raises KeyError for a name that no section has: none of the robot, and none of the tool itself.
        """
        if isinstance(section, str):
            own = own_sections().get(section)
            return self.values[section] if own is None else self[own]
        return self.values.get(section.name, section.empty())

    def having(self, section: Section[T] | str, value: T) -> Sections:
        """Return them with another value of a section, or of the one of a name."""
        name = section if isinstance(section, str) else section.name
        return replace(self, values={**self.values, name: value})

    def taking(self, names: Collection[str], other: Sections) -> Sections:
        """Return them with the values of some names as another one has them, or has none."""
        kept = {name: one for name, one in self.values.items() if name not in names}
        taken = {name: one for name, one in other.values.items() if name in names}
        return replace(self, values={**kept, **taken})

    def __contains__(self, section: object) -> bool:
        """Say whether the robot has a section, or one of a name."""
        return getattr(section, "name", section) in self.values


NO_SECTIONS = Sections()
