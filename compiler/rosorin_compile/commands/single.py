"""What the commands about one robot share: which one is meant, what it is, and where its numbers were written."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..console import Console
from ..project import ENDINGS, Description
from ..registry import ASKING, Rule
from .shared import Given, WrongUsage, compile_one, descriptions, given_arguments, nothing_written

if TYPE_CHECKING:
    from ..diagnostic import Diagnostic
    from ..kinematics.states import Beyond
    from ..model import Edge, Robot
    from ..pipeline import Compiled, Understood
    from ..rules.case import Case

RULES = (
    Rule(
        "position-beyond-limit",
        "A position that is asked for is beyond the limit of a joint; a warning, with `--strict` an error.",
        "Another position, or another limit.",
        ASKING,
    ),
)


class Known(NamedTuple):
    """A robot without errors, and where it was written."""

    robot: Robot
    case: Case


def one(name: str, how: str) -> Description:
    """Return the description of a name, or the only one here. Raises WrongUsage; ``how`` says how to name one."""
    found = descriptions([name] if name else [])
    if len(found) > 1:
        robots = ", ".join(description.name for description in found)
        raise WrongUsage(f"there are several robots here: {robots}; name one: {how}")
    return found[0]


def compiled_one(options: argparse.Namespace, several: str, how: str) -> tuple[Console, Description, Compiled | None]:
    """Compile the one robot that a command asks for, and say what is wrong; None for one with errors or no artifacts.

    ``several`` says why it is one. Raises WrongUsage.
    """
    from ..diagnostic import has_errors

    given, names = given_arguments(options, options.words)
    if len(names) > 1:
        raise WrongUsage(f"{several}: {how}")
    description = one(names[0] if names else "", how)
    console = Console(options.format)
    compiled = compile_one(given, description, console)
    console.show(compiled.diagnostics)
    if compiled.robot is not None and not has_errors(compiled.diagnostics):
        return console, description, compiled
    nothing_written(console, description.name, compiled.diagnostics)
    return console, description, None


def is_foreign(path: Path) -> bool:
    """Say whether a file is no description but a robot in another format, by its name."""
    if path.suffix.lower() in ("", *ENDINGS):
        return False
    from ..emit import endings

    return path.suffix.lower() in endings()


def read(given: Given, description: Description, console: Console) -> Understood:
    """Return what a description says, or a URDF, xacro, MJCF or driver's JSON in its place. Raises LoadError."""
    arguments = given.values()
    if is_foreign(description.path):
        from ..importing.asking import understand_foreign

        return understand_foreign(description.path, texts(arguments), given.packages, console.ahead)
    from ..pipeline import understand

    return understand(description.path, arguments, console.ahead)


def texts(arguments: Mapping[str, Any]) -> dict[str, str]:
    """Return arguments as xacro takes them."""
    return {name: str(value) for name, value in arguments.items()}


def understood(given: Given, description: Description, console: Console) -> Known | None:
    """Return the robot of a description; None, after saying what is wrong, of one with errors."""
    from ..diagnostic import has_errors
    from ..load import LoadError
    from ..rules.case import Case
    from ..rules.remarkable import collect

    try:
        expanded, built, diagnostics = read(given, description, console)
    except LoadError as problem:
        console.show([problem.diagnostic])
        return None
    if built is None or built.robot is None or expanded.tree is None or has_errors(diagnostics):
        console.show([diagnostic for diagnostic in diagnostics if diagnostic.severity == "error"])
        console.warn(f"{description.name}: a description with errors has no frames and joints to ask about")
        return None
    return Known(built.robot, Case(built.robot, expanded.tree, built.places, collect(expanded.tree)))


def beyond_limit(known: Known, found: Beyond, severity: str) -> Diagnostic:
    """Return what is to say about a position beyond a limit, at the place of the limit."""
    from ..formatting import exact

    joint, side = found.joint, "below" if found.side == "lower" else "above"
    unit = "m" if joint.type == "prismatic" else "rad"
    message = (
        f'joint "{joint.name}" at {exact(found.position)} {unit} is {side} its {found.side} limit'
        f" of {exact(found.limit)} {unit}"
    )
    help = "the joint does not get there; with --strict this is an error"
    path = known.case.joint(joint, "limit", found.side)
    return known.case.problem("position-beyond-limit", message, path, help, severity=severity)


def edge_index(robot: Robot, edge: Edge) -> int:
    """Return the place of an edge in the list of the description."""
    return next(index for index, one in enumerate(robot.edges) if one is edge)
