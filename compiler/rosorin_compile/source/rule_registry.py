"""The registry of rules, which are declared by ``@rule`` on a function, or listed in ``schemas/rules.json``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Iterable, Mapping
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
    """Headings of docs/rules.md under which rules are listed; ``schemas/rules.json`` has further headings."""

    FILES, ARGUMENTS = "Files and YAML", "Arguments, named values, expressions, parts"
    SHAPE, JOINTS, NUMBERS, POSES = "Shape", "Links and joints", "Numbers", "Servos and poses"
    FRAMES, OUTPUTS, FORMATS = "Frames and publishers", "Outputs and stand-ins", "Unsupported by a format"
    SIMULATED, SIMULATION, PHYSICS = "MuJoCo keys and elements", "Simulation", "Physics"
    CONTROL, PLUGINS = "Hardware and controllers of ros2_control", "Plug-ins"


ARGUMENTS, JOINTS, NUMBERS, POSES = Heading.ARGUMENTS, Heading.JOINTS, Heading.NUMBERS, Heading.POSES
FRAMES, OUTPUTS, SIMULATED, PHYSICS = Heading.FRAMES, Heading.OUTPUTS, Heading.SIMULATED, Heading.PHYSICS
SIMULATION, PLUGINS = Heading.SIMULATION, Heading.PLUGINS
_ID = "[a-z0-9]+(-[a-z0-9]+)*"
_ACCEPT, _IMPORTED = ("", "link", "joint", "link or joint"), ("", "always", "lenient")


class Rule(NamedTuple):
    """A rule for robots or their files; diagnostics refer to it by ``id``, and docs/rules.md documents it."""

    id: str
    what: str = ""  # Markdown
    help: str = ""  # Markdown
    topic: str = ""  # heading in docs/rules.md
    accept: str = ""  # what an "accept" entry must name to suppress the rule: "link", "joint", "link or joint"
    imported: str = ""  # when imported descriptions suppress the rule: "always", or "lenient" (with --lenient)
    asked: str = ""  # "meshes", "physics" or "simulation": the rule is checked only if this is requested

    @property
    def mild(self) -> bool:
        """Whether ``what`` mentions a warning or note, that is, whether the rule can report less than an error."""
        return re.search(r"(?i)(?<![^\s:,])(warning|note)(?![^\s:,])", self.what) is not None

    @property
    def severity(self) -> str:
        """The default severity: "warning" or "note" if ``what`` begins with "A warning" or "A note", else "error"."""
        return next((word for word in ("warning", "note") if self.what.startswith(f"A {word}")), "error")

    @property
    def hint(self) -> str:
        """The text ``help`` as the help line of a diagnostic: plain text that begins in lower case."""
        text = self.help.replace("`", '"').removesuffix(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text


class Check(NamedTuple):
    """A function that checks a robot and yields diagnostics, and the rules that these diagnostics refer to."""

    function: Look
    rules: tuple[Rule, ...] = ()

    def __call__(self, case: Case) -> Iterable[Diagnostic]:
        return self.function(case)

    def ids(self) -> list[str]:
        """Return the ids of the rules. Raises ValueError if a rule is invalid, or if there are no rules."""
        for rule in self.rules:
            if not re.fullmatch(_ID, rule.id) or rule.accept not in _ACCEPT or rule.imported not in _IMPORTED:
                what = f"its id has small letters and single hyphens, accept is in {_ACCEPT}, imported in {_IMPORTED}"
                raise ValueError(f'the rule "{rule.id}" is invalid: {what}')
        if not self.rules:
            raise ValueError("it declares no rule; put @rule above the function")
        return [rule.id for rule in self.rules]


def rule(
    id: str, what: str = "", help: str = "", topic: str = PLUGINS, accept: str = "", imported: str = ""
) -> Callable[[Look | Check], Check]:
    """Declare a rule that the decorated function checks; use several decorators for several rules.

    The arguments are the fields of ``Rule``. ``what`` defaults to the first paragraph of the function's docstring.
    """

    def decorate(function: Look | Check) -> Check:
        check = function if isinstance(function, Check) else Check(function)
        text = what or " ".join((check.function.__doc__ or "").strip().partition("\n\n")[0].split())
        declared = DECLARED[id] = Rule(id, text, help, topic, accept, imported)
        return Check(check.function, (declared, *check.rules))

    return decorate


def checks_of(module: ModuleType) -> tuple[Check, ...]:
    """Return the checks that a module defines, in the order of their definition."""
    checks = (value for value in vars(module).values() if isinstance(value, Check))
    return tuple(check for check in checks if check.function.__module__ == module.__name__)


# Rules by id: rules declared with ``@rule`` in imported modules, and rules of loaded plug-ins.
DECLARED: dict[str, Rule] = {}
OF_PLUGINS: dict[str, Rule] = {}


@cache
def of_stages() -> Mapping[str, Rule]:
    """Return the rules in ``schemas/rules.json``, which no function with ``@rule`` declares, by id."""
    headings = json.loads((data_folder("schemas") / "rules.json").read_text("utf-8"))
    return {id: Rule(id, topic=topic, **texts) for topic, rules in headings.items() for id, texts in rules.items()}


def find_declared(id: str) -> Rule:
    """Return a rule without importing modules, or a rule with an empty id if no imported module declares it."""
    return DECLARED.get(id) or of_stages().get(id) or Rule("", "")


def find(ids: Collection[str] | None = None) -> dict[str, Rule]:
    """Return the built-in rules by id, or only those in ``ids``, and import the modules that declare them."""
    package, found = Path(__file__).parents[1], dict(of_stages())
    quoted = [f'"{id}"'.encode() for id in ids or () if id not in found]
    for path in sorted(package.glob("**/*.py")):
        text = path.read_bytes()
        if b"@rule(" in text and (ids is None or any(id in text for id in quoted)):
            name = ".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__")
            found |= {rule.id: rule for check in checks_of(import_module(name)) for rule in check.rules}
    return {id: rule for id, rule in found.items() if ids is None or id in ids}
