"""What sweep answers as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class SweepCounts(TypedDict):
    """What came of the variants of a list; `sweep.json` in the folder has each of them."""

    description: Annotated[str, "the first file of the robot"]
    folder: str
    made: int
    unchanged: int
    error: Annotated[int, "how many have errors"]


class NinjaFile(TypedDict):
    """A build file for Ninja that makes the variants."""

    description: str
    folder: str
    ninja: Annotated[str, "the file"]


ANSWERS: dict[str, Any] = {"sweep": SweepCounts | NinjaFile}
