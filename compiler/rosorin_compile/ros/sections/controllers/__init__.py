"""The section ``controllers``: the controllers that ros2_control loads, with their parameters."""

from collections.abc import Iterator, Mapping
from typing import Any

from rosorin_compile.language.lower import Problem, entries_of, plain, record_of
from rosorin_compile.language.schema import named_as
from rosorin_compile.model import Controller
from rosorin_compile.model.sections import Section
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import Check
from rosorin_compile.source.tree import Path


def controllers_of(tree: Mapping[str, Any], _: Problem) -> tuple[Controller, ...]:
    """Parse the section ``controllers``."""
    made = []
    for name, entry in entries_of(tree, "controllers"):
        params = {key: plain(value) for key, value in flat(entry.get("params") or {}).items()}
        made.append(record_of(Controller, entry, name=name, params=params))
    return tuple(made)


def flat(params: Mapping[str, Any], above: str = "") -> dict[str, Any]:
    """Flatten nested parameters, joining the keys with dots; ``above`` is a prefix for all keys.

    >>> flat({"a": {"b": 1, "c.d": 2}})
    {'a.b': 1, 'a.c.d': 2}
    """
    found: dict[str, Any] = {}
    for key, value in params.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{above}{key}.")
        else:
            found[f"{above}{key}"] = value
    return found


@Check
def controller_names(case: Case) -> Iterator[Diagnostic]:
    """Report controllers that name an unknown hardware block or sensor (controller-name)."""
    blocks = [name for section in named_as("hardware block") for name in case.tree.get(section) or ()]
    sensors = [sensor.name for sensor in case.robot.sensors]
    for one in case.robot.controllers:
        for key, word, known in (("hardware", "hardware block", blocks), ("sensor", "sensor", sensors)):
            if (name := getattr(one, key)) and name not in known:
                path: Path = ("controllers", one.name, key)
                message = f'controller "{one.name}" refers to {word} "{name}", which does not exist'
                help = case.suggest(path, name, known, none=f'the robot has no {word}: add "{name}"')
                yield case.problem("controller-name", message, path, help)


SECTION: Section[tuple[Controller, ...]] = Section("controllers", lower=controllers_of, checks=(controller_names,))
