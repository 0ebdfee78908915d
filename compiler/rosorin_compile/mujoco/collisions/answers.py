"""What collisions answers as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class DisabledPair(TypedDict):
    """Two links that MoveIt need not check against each other."""

    links: Annotated[list[str], "their names"]
    reason: Annotated[str, "why not"]


class _MatrixMore(TypedDict, total=False):
    states: Annotated[int, "how many random states were tried"]
    pairs: list[DisabledPair]


class CollisionMatrix(_MatrixMore):
    """The collision matrix of a robot."""

    robot: str
    file: str
    written: Annotated[bool, "false: the file is that of the robot already"]


ANSWERS: dict[str, Any] = {"collisions": CollisionMatrix}
