"""What package and deploy answer as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class WrittenPackage(TypedDict):
    """A ROS 2 package."""

    package: str
    folder: str
    files: Annotated[list[str], "all files of it, as seen from the folder"]
    written: Annotated[list[str], "those that are new or others than before"]


class DeployedCopy(TypedDict):
    """An artifact in a folder."""

    file: Annotated[str, "as seen from the folder"]
    output: Annotated[str, "its name under `outputs`"]
    same: Annotated[bool, "whether it was there as it is compiled before the run"]


class Deployed(TypedDict):
    """The artifacts of a robot in a folder."""

    robot: str
    folder: str
    written: Annotated[bool, "false with `--dry-run`"]
    copies: list[DeployedCopy]


ANSWERS: dict[str, Any] = {"deploy": Deployed, "package": WrittenPackage}
