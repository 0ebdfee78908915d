"""SRDF: what MoveIt has to know of a robot beside its URDF.

``planning`` knows which links and joints it may speak of, and what a group has; ``write`` makes the text, ``reading``
reads it for comparison, and what people have beside a URDF. ``checks`` finds what the section ``moveit`` says wrongly,
``matrix`` whether its matrix is of the robot.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ..format import NUMBER_FORMAT, Asked, Facts, Format, Joined, Opened

if TYPE_CHECKING:
    from ...diagnostics import Diagnostic
    from ...frontend.tree import Map
    from ...model import Output, Robot
    from ...rules.case import Case
    from ...xml.markup import Document
    from ..templating import Templates

__all__ = ["FORMAT"]


def _write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    from .write import write

    return write(robot, output, templates)


def _facts(text: str) -> Facts:
    from .reading import facts

    return facts(text)


def _syntax(text: str) -> object:
    from ...xml.elements import canonical, tree_of

    return canonical(tree_of(text))


def _check(case: Case, output: Output) -> Iterator[Diagnostic]:
    from .checks import check

    return check(case, output)


def _join(opened: Opened, tree: Map) -> Joined:
    from .reading import join

    return join(opened, tree)


def _is_other(document: Document) -> bool:
    """Say whether a document has elements of an SRDF, and neither links nor joints."""
    tags = {child.tag for child in document.root.children}
    return document.root.tag == "robot" and bool(tags & _OWN) and not tags & {"link", "joint"}


def _asked(tree: Map, _: str, name: str) -> Asked | None:
    return Asked({"file": f"{name}.srdf"}) if "moveit" in tree else None


_OWN = {"group", "group_state", "end_effector", "virtual_joint", "disable_collisions", "passive_joint"}

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
    join=_join,
    joins=("moveit",),
    is_other=_is_other,
    facts=_facts,
    syntax=_syntax,
    folder="srdf",
    deploys=True,
    measures=True,
    asked=_asked,
)
