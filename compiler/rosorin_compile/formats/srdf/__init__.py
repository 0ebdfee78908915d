"""SRDF: what MoveIt has to know of a robot beside its URDF.

``planning`` knows which links and joints it may speak of, and what a group has; ``write`` makes the text, ``facts``
reads it back, ``checks`` finds what the section ``moveit`` says wrongly, ``matrix`` whether its matrix is of the robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..format import NUMBER_FORMAT, Facts, Format

if TYPE_CHECKING:
    from ...diagnostics import Diagnostic
    from ...model import Output, Robot
    from ...rules.case import Case
    from ..templating import Templates

__all__ = ["FORMAT"]


def _write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    from .write import write

    return write(robot, output, templates)


def _facts(text: str) -> Facts:
    from .facts import read

    return read(text)


def _syntax(text: str) -> object:
    from ...xml.elements import canonical, tree_of

    return canonical(tree_of(text))


def _check(case: Case, output: Output) -> Iterator[Diagnostic]:
    from .checks import check

    return check(case, output)


FORMAT = Format(
    name="srdf",
    word="SRDF",
    article="an",
    about="what MoveIt has to know beside the URDF",
    rank=25,
    options={"number_format": NUMBER_FORMAT},
    file="{}.srdf",
    endings=(".srdf",),
    check=_check,
    write=_write,
    facts=_facts,
    syntax=_syntax,
    folder="srdf",
    deploys=True,
)
