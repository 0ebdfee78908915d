"""The registry of rules: checks of robots are functions under ``@rule``; ``schemas/rules.json`` has the others."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

from .project import data_folder

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

    from .diagnostics import Diagnostic

    Look = Callable[[Case], Iterable[Diagnostic]]


class Heading:
    """The headings of the page of rules by name; ``schemas/rules.json`` has more."""

    FILES, ARGUMENTS = "Files and YAML", "Arguments, named values, expressions, parts"
    SHAPE, JOINTS, NUMBERS, POSES = "Shape", "Links and joints", "Numbers", "Servos and poses"
    FRAMES, OUTPUTS, FORMATS = "Frames and publishers", "Outputs and stand-ins", "Unsupported by a format"
    SIMULATED, SIMULATION, PHYSICS = "MuJoCo keys and elements", "Simulation", "Physics"
    CONTROL, PLUGINS = "Hardware and controllers of ros2_control", "Plug-ins"


# The same as plain names, for modules of the core.
ARGUMENTS, JOINTS, NUMBERS, POSES = Heading.ARGUMENTS, Heading.JOINTS, Heading.NUMBERS, Heading.POSES
FRAMES, OUTPUTS, SIMULATED, PHYSICS = Heading.FRAMES, Heading.OUTPUTS, Heading.SIMULATED, Heading.PHYSICS
SIMULATION, PLUGINS = Heading.SIMULATION, Heading.PLUGINS
_ID = re.compile("[a-z0-9]+(-[a-z0-9]+)*")
_ACCEPT, _IMPORTED = ("", "link", "joint", "link or joint"), ("", "always", "lenient")


@dataclass(frozen=True)
class Rule:
    """The entry of a rule on the page of rules."""

    id: str
    what: str = ""  # Markdown
    help: str = ""  # Markdown
    topic: str = ""  # the heading
    accept: str = ""  # what a description may name that breaks it: "link", "joint", "link or joint"
    imported: str = ""  # a robot in another format is accepted like that: "always", "lenient"
    asked: str = ""  # what a run requests to check it: "meshes", "physics", "simulation"

    @property
    def mild(self) -> bool:
        """Whether it can be a warning or a note, by its text."""
        return re.search(r"(?i)(?<![^\s:,])(warning|note)(?![^\s:,])", self.what) is not None

    @property
    def severity(self) -> str:
        """The severity of its problems where they do not name another: its entry begins with "A warning" or a note."""
        return next((word for word in ("warning", "note") if self.what.startswith(f"A {word}")), "error")

    @property
    def hint(self) -> str:
        """The fix as the help of a diagnostic: plain text that begins with a small letter."""
        text = self.help.replace("`", "").removesuffix(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text


class Check(NamedTuple):
    """A function that yields diagnostics of a robot, and the rules that are declared with it."""

    function: Look
    rules: tuple[Rule, ...] = ()

    def __call__(self, case: Case) -> Iterable[Diagnostic]:
        return self.function(case)

    def ids(self) -> list[str]:
        """Return the ids of the rules. Raises ValueError if one is invalid, or if there is none."""
        for rule in self.rules:
            if not _ID.fullmatch(rule.id) or rule.accept not in _ACCEPT or rule.imported not in _IMPORTED:
                what = f"its id has small letters and single hyphens, accept is in {_ACCEPT}, imported in {_IMPORTED}"
                raise ValueError(f'the rule "{rule.id}" is invalid: {what}')
        if not self.rules:
            raise ValueError("it declares no rule; put @rule above the function")
        return [rule.id for rule in self.rules]


def rule(
    id: str, what: str = "", help: str = "", topic: str = PLUGINS, accept: str = "", imported: str = ""
) -> Callable[[Look | Check], Check]:
    """Declare a rule (see ``Rule``; ``what`` is by default the first paragraph of the docstring) of a function."""

    def decorate(function: Look | Check) -> Check:
        check = function if isinstance(function, Check) else Check(function)
        text = what or " ".join((check.function.__doc__ or "").strip().partition("\n\n")[0].split())
        declared = DECLARED[id] = Rule(id, text, help, topic, accept, imported)
        return Check(check.function, (declared, *check.rules))

    return decorate


def checks_of(module: ModuleType) -> tuple[Check, ...]:
    """Return the checks that a module defines, in its order."""
    checks = (value for value in vars(module).values() if isinstance(value, Check))
    return tuple(check for check in checks if check.function.__module__ == module.__name__)


# The rules of the functions under ``rule`` that were imported, and those of plug-ins of this run, by id.
DECLARED: dict[str, Rule] = {}
OF_PLUGINS: dict[str, Rule] = {}


@cache
def of_stages() -> Mapping[str, Rule]:
    """Return the rules that no function under ``rule`` declares, by id: ``schemas/rules.json`` has them by heading."""
    headings = json.loads((data_folder("schemas") / "rules.json").read_text("utf-8"))
    return {id: Rule(id, topic=topic, **texts) for topic, rules in headings.items() for id, texts in rules.items()}


def find_declared(id: str) -> Rule:
    """Return a rule of a module that is imported, or of a stage; an empty one if there is none."""
    return DECLARED.get(id) or of_stages().get(id) or Rule("", "")


def find(ids: Collection[str] | None = None) -> dict[str, Rule]:
    """Return the tool's own rules by id: all, or those of ``ids``; only modules that declare them are imported."""
    package = Path(__file__).parents[1]
    found = dict(of_stages())
    quoted = [f'"{id}"'.encode() for id in ids or () if id not in found]
    for path in sorted(package.glob("**/*.py")):
        text = path.read_bytes()
        if b"@rule(" in text and (ids is None or any(id in text for id in quoted)):
            name = ".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__")
            found |= {rule.id: rule for check in checks_of(import_module(name)) for rule in check.rules}
    return {id: rule for id, rule in found.items() if ids is None or id in ids}
