"""What view answers as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class WrittenPage(TypedDict):
    """A page with a robot."""

    robot: str
    file: str
    bytes: Annotated[int, "its size"]


ANSWERS: dict[str, Any] = {"view": WrittenPage}
