"""What check fleet answers as JSON: the types of its result, of which the schema is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any


@dataclass(frozen=True)
class FleetOutlier:
    """A robot whose number is far from that of the others."""

    robot: str
    number: Annotated[str, "its name"]
    value: Annotated[float, "in the unit of the number"]
    sigmas: Annotated[float | None, "how many standard deviations it is off; null where most have one and the same"]


@dataclass(frozen=True)
class FleetNumber:
    """A number that differs between robots."""

    name: Annotated[str, "the argument, or what an artifact says"]
    argument: Annotated[bool, "whether the sweep gave it"]
    unit: Annotated[str, "SI; empty: none is known"]
    robots: Annotated[int, "how many have it"]
    smallest: float
    median: float
    largest: float
    width: Annotated[float, "its robust standard deviation; 0 where most have one and the same"]
    gives: Annotated[list[str], "what else of the artifacts follows it"]


@dataclass(frozen=True)
class CheckedFleet:
    """The robots of a sweep, held against each other; the diagnostics say what is wrong."""

    file: str
    fine: Annotated[bool, "whether there is no error"]
    robots: int
    made: int
    failed: int
    with_outliers: int
    with_stand_ins: int
    drawn: Annotated[int, "how many robots the medians are those of: of a large fleet not all"]
    differing: Annotated[int, "how many numbers of the artifacts differ between robots"]
    same: Annotated[int, "how many are the same in all robots"]
    numbers: Annotated[list[FleetNumber], "those that differ, arguments first"]
    outliers: list[FleetOutlier]


ANSWERS: dict[str, Any] = {"check fleet": CheckedFleet}
