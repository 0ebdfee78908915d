"""The registry of rules: what each id of a diagnostic means.

A rule about the meaning of a robot is a function under ``@rule``; rules of other stages are declared in a tuple
``RULES`` next to their code.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

    from .diagnostics import Diagnostic

    Look = Callable[[Case], Iterable[Diagnostic]]


class Heading:
    """The headings of the page of rules by name."""

    FILES = "Files and YAML"
    ARGUMENTS = "Arguments, named values, expressions, parts"
    SHAPE = "Shape"
    JOINTS = "Links and joints"
    NUMBERS = "Numbers"
    POSES = "Servos and poses"
    FRAMES = "Frames and publishers"
    OUTPUTS = "Outputs and stand-ins"
    FORMATS = "Unsupported by a format"
    SIMULATED = "MuJoCo keys and elements"
    SIMULATION = "Simulation"
    CONTROL = "Hardware and controllers of ros2_control"
    TEMPLATES = "Templates"
    WRITING = "Writing and comparing"
    READING = "Robots in other formats"
    MESHES = "Numbers from meshes"
    PHYSICS = "Physics"
    ASKING = "Transforms and pulses"
    PACKAGES = "ROS packages"
    RECORDINGS = "Recordings"
    PARAMETERS = "Parameters of nodes"
    NAVIGATION = "Navigation and localisation"
    PLUGINS = "Plug-ins"


# The same as plain names, for modules of the core.
FILES, ARGUMENTS, SHAPE, JOINTS = Heading.FILES, Heading.ARGUMENTS, Heading.SHAPE, Heading.JOINTS
NUMBERS, POSES, FRAMES, OUTPUTS = Heading.NUMBERS, Heading.POSES, Heading.FRAMES, Heading.OUTPUTS
FORMATS, SIMULATED, SIMULATION, TEMPLATES = Heading.FORMATS, Heading.SIMULATED, Heading.SIMULATION, Heading.TEMPLATES
WRITING, READING, MESHES, PHYSICS = Heading.WRITING, Heading.READING, Heading.MESHES, Heading.PHYSICS
ASKING, PACKAGES, RECORDINGS, PARAMETERS = Heading.ASKING, Heading.PACKAGES, Heading.RECORDINGS, Heading.PARAMETERS
NAVIGATION, PLUGINS = Heading.NAVIGATION, Heading.PLUGINS


@dataclass(frozen=True)
class Rule:
    """The entry of a rule on the page of rules.

    ``what`` and ``help`` are Markdown with links relative to ``docs``; ``topic`` is the heading. ``accept``: what a
    description may name that breaks the rule ("link", "joint", "link or joint" or empty). ``imported``: whether a robot
    in another format is accepted like that ("always", "lenient" or empty). ``asked``: what a run has to request to
    check it ("meshes", "physics", "simulation" or empty).
    """

    id: str
    what: str
    help: str = ""
    topic: str = ""
    accept: str = ""
    imported: str = ""
    asked: str = ""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not isinstance(value, str):
                raise TypeError(f"{name} of a rule is a text, not {str(value)[:60]!r}")

    @property
    def mild(self) -> bool:
        """Whether it can be a warning or a note, by its text."""
        return bool({"warning", "note"} & set(self.what.lower().replace(":", " ").replace(",", " ").split()))

    @property
    def severity(self) -> str:
        """The severity of its problems where they do not name another: its entry begins with "A warning" or a note."""
        return next((word for word in ("warning", "note") if self.what.startswith(f"A {word}")), "error")

    @property
    def hint(self) -> str:
        """The fix as the help of a diagnostic: plain text that begins with a small letter."""
        text = self.help.replace("`", "").removesuffix(".")
        return text[:1].lower() + text[1:] if text[1:2].islower() else text


def declare(topic: str, rules: Mapping[str, str]) -> tuple[Rule, ...]:
    """Declare rules of one topic that ``Case.problem`` reports: by id, what is wrong, then "Fix:" and what to do."""
    texts = {id: text.partition(" Fix: ") for id, text in rules.items()}
    declared = tuple(Rule(id, what, help, topic) for id, (what, _, help) in texts.items())
    DECLARED.update((rule.id, rule) for rule in declared)
    return declared


class Check(NamedTuple):
    """A function that yields diagnostics of a robot, and the rules that are declared with it."""

    function: Look
    rules: tuple[Rule, ...] = ()

    def __call__(self, case: Case) -> Iterable[Diagnostic]:
        """Return the diagnostics of a robot."""
        return self.function(case)


def rule(
    id: str, what: str = "", help: str = "", topic: str = PLUGINS, accept: str = "", imported: str = ""
) -> Callable[[Look | Check], Check]:
    """Declare a rule, and make a check of the function that yields its diagnostics; one decorator for each rule.

    The arguments are those of ``Rule``; without ``what`` it is the first paragraph of the docstring. A plug-in names
    the function as an entry point of ``rosorin_compile.rules``.
    """

    def decorate(function: Look | Check) -> Check:
        check = function if isinstance(function, Check) else Check(function)
        text = what or _first_paragraph(check.function.__doc__)
        declared = DECLARED[id] = Rule(id, text, help, topic, accept, imported)
        return Check(check.function, (declared, *check.rules))

    return decorate


def _first_paragraph(doc: str | None) -> str:
    return " ".join((doc or "").strip().partition("\n\n")[0].split())


def checks_of(module: ModuleType) -> tuple[Check, ...]:
    """Return the checks that a module defines, in its order."""
    checks = (value for value in vars(module).values() if isinstance(value, Check))
    return tuple(check for check in checks if check.function.__module__ == module.__name__)


# The rules of the functions under ``rule`` that were imported, and those of plug-ins of this run, by id.
DECLARED: dict[str, Rule] = {}
OF_PLUGINS: dict[str, Rule] = {}


def find(ids: Collection[str]) -> dict[str, Rule]:
    """Return those of the tool's own rules that have one of the ids, by id."""
    quoted = [f'"{id}"'.encode() for id in ids]
    return {rule.id: rule for rule in _declared(lambda text: any(map(text.__contains__, quoted))) if rule.id in ids}


def every_rule() -> dict[str, Rule]:
    """Return the tool's own rules by id."""
    return {rule.id: rule for rule in _declared(lambda _: True)}


def _declared(is_wanted: Callable[[bytes], bool]) -> Iterator[Rule]:
    """Yield the rules that modules of the tool declare; only modules that declare rules are imported."""
    package = Path(__file__).parents[1]
    for path in sorted(package.glob("**/*.py")):
        text = path.read_bytes()
        if any(mark in text for mark in (b"Rule(", b"@rule(", b"declare(")) and is_wanted(text):
            name = ".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(".__init__")
            module = import_module(name)
            yield from getattr(module, "RULES", ())
            yield from (rule for check in checks_of(module) for rule in check.rules)
