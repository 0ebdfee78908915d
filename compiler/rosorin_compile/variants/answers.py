"""The type of the JSON result of sweep, from which its schema is generated."""

from typing import Any, TypedDict


class SweepCounts(TypedDict):
    """The number of variants by their status; `sweep.json` in the folder lists them."""

    description: str
    folder: str
    made: int
    unchanged: int
    error: int


ANSWERS: dict[str, Any] = {"sweep": SweepCounts}
