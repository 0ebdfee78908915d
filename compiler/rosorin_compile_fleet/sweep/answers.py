"""The type of the JSON result of sweep, from which its schema is generated."""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class SweepCounts(TypedDict):
    """The number of variants by their status; `sweep.json` in the folder lists them."""

    description: Annotated[str, "the first file of the robot"]
    folder: str
    made: int
    unchanged: int
    error: Annotated[int, "how many have errors"]


ANSWERS: dict[str, Any] = {"sweep": SweepCounts}
