"""The registry of rules: ``@rule`` declares those that check a robot; ``schemas/rules.json`` has all others."""

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
    """Headings of the reference page of rules; ``schemas/rules.json`` has more."""

    FILES, ARGUMENTS = "Files and YAML", "Arguments, named values, expressions, parts"
    SHAPE, JOINTS, NUMBERS, POSES = "Shape", "Links and joints", "Numbers", "Servos and poses"
    FRAMES, OUTPUTS, FORMATS = "Frames and publishers", "Outputs and stand-ins", "Unsupported by a format"
    SIMULATED, SIMULATION, PHYSICS = "MuJoCo keys and elements", "Simulation", "Physics"
    CONTROL, PLUGINS = "Hardware and controllers of ros2_control", "Plug-ins"


# Aliases for modules of the core.
ARGUMENTS, JOINTS, NUMBERS, POSES = Heading.ARGUMENTS, Heading.JOINTS, Heading.NUMBERS, Heading.POSES
FRAMES, OUTPUTS, SIMULATED, PHYSICS = Heading.FRAMES, Heading.OUTPUTS, Heading.SIMULATED, Heading.PHYSICS
SIMULATION, PLUGINS = Heading.SIMULATION, Heading.PLUGINS
_ID = re.compile("[a-z0-9]+(-[a-z0-9]+)*")
_ACCEPT, _IMPORTED = ("", "link", "joint", "link or joint"), ("", "always", "lenient")


@dataclass(frozen=True)
class Rule:
    """A rule as the reference page documents it."""

    id: str
    what: str = ""  # Markdown
    help: str = ""  # Markdown
    topic: str = ""  # heading on the page
    accept: str = ""  # kind of names under which a description may accept the rule: "link", "joint", "link or joint"
    imported: str = ""  # when ``import`` writes an ``accept`` that suppresses the rule: "always", or with --lenient
    asked: str = ""  # what must be requested for the rule to be checked: "meshes", "physics", "simulation"

    @property
    def mild(self) -> bool:
        """Whether diagnostics of the rule can be warnings or notes, according to its text."""
        return re.search(r"(?i)(?<![^\s:,])(warning|note)(?![^\s:,])", self.what) is not None

    @property
    def severity(self) -> str:
        """The default severity of the rule: "warning" or "note" if its text begins with that word, else "error"."""
        return next((word for word in ("warning", "note") if self.what.startswith(f"A {word}")), "error")

    @property
    def hint(self) -> str:
        """The fix as a help line that begins in lower case."""
        text = self.help.replace("`", '"').removesuffix(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text


class Check(NamedTuple):
    """A function that checks a robot and yields diagnostics, with the rules that it declares."""

    function: Look
    rules: tuple[Rule, ...] = ()

    def __call__(self, case: Case) -> Iterable[Diagnostic]:
        return self.function(case)

    def ids(self) -> list[str]:
        """Return the ids of the rules. Raises ValueError if a rule is invalid, or without rules."""
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
    """Declare a rule that the decorated function checks; ``what`` defaults to the first paragraph of its docstring."""

    def decorate(function: Look | Check) -> Check:
        check = function if isinstance(function, Check) else Check(function)
        text = what or " ".join((check.function.__doc__ or "").strip().partition("\n\n")[0].split())
        declared = DECLARED[id] = Rule(id, text, help, topic, accept, imported)
        return Check(check.function, (declared, *check.rules))

    return decorate


def checks_of(module: ModuleType) -> tuple[Check, ...]:
    """Return the checks that a module defines, in the order of definition."""
    checks = (value for value in vars(module).values() if isinstance(value, Check))
    return tuple(check for check in checks if check.function.__module__ == module.__name__)


# Rules declared with ``@rule`` in modules imported so far, and rules of the plug-ins of this run, by id.
DECLARED: dict[str, Rule] = {}
OF_PLUGINS: dict[str, Rule] = {}


@cache
def of_stages() -> Mapping[str, Rule]:
    """Return the rules of ``schemas/rules.json``, which no function declares, by id."""
    headings = json.loads((data_folder("schemas") / "rules.json").read_text("utf-8"))
    return {id: Rule(id, topic=topic, **texts) for topic, rules in headings.items() for id, texts in rules.items()}


def find_declared(id: str) -> Rule:
    """Return a rule that an imported module or ``schemas/rules.json`` declares, or an empty rule."""
    return DECLARED.get(id) or of_stages().get(id) or Rule("", "")


def find(ids: Collection[str] | None = None) -> dict[str, Rule]:
    """Return the built-in rules by id, all or those of ``ids``; import only the modules that declare them."""
    package = Path(__file__).parents[1]
    found = dict(of_stages())
    quoted = [f'"{id}"'.encode() for id in ids or () if id not in found]
    for path in sorted(package.glob("**/*.py")):
        text = path.read_bytes()
        if b"@rule(" in text and (ids is None or any(id in text for id in quoted)):
            name = ".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__")
            found |= {rule.id: rule for check in checks_of(import_module(name)) for rule in check.rules}
    return {id: rule for id, rule in found.items() if ids is None or id in ids}
