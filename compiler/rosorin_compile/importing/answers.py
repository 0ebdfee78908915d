"""What import answers as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class ImportedRobot(TypedDict):
    """A description that was made of a robot."""

    source: str
    robot: Annotated[str, "its name"]
    folder: Annotated[str, "where the description is"]


ANSWERS: dict[str, Any] = {"import": ImportedRobot}
