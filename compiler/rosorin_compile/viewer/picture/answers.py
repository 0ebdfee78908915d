"""What picture answers as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class DrawnPicture(TypedDict):
    """A picture of a robot."""

    robot: str
    file: str
    width: Annotated[int, "pixels"]
    height: Annotated[int, "pixels"]


ANSWERS: dict[str, Any] = {"picture": DrawnPicture}
