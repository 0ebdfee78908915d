"""What check physics answers as JSON: the types of its result, of which the schema is made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from rosorin_compile.source.diagnostics import counted, listed


@dataclass(frozen=True)
class LookedAt:
    """What of a robot the engine was shown: zero, its poses, its joints over their ranges, its meshes."""

    poses: Annotated[int, "how many named poses; position zero comes on top"]
    joints: Annotated[int, "how many joints, each led over its range"]
    meshes: Annotated[int, "how many files of meshes"]

    def __str__(self) -> str:
        at = [f"the ranges of {counted(self.joints, 'joint')}"] if self.joints else []
        at += [counted(self.meshes, "mesh")] if self.meshes else []
        return listed([counted(self.poses, "pose"), "zero", *at] if self.poses else ["zero", *at])


@dataclass(frozen=True)
class CheckedPhysics:
    """What came of the physics of one robot."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether there is no error; the exit code is 0 where all are fine"]
    looked_at: Annotated[LookedAt | None, "null where the robot has errors before that"]


@dataclass(frozen=True)
class PhysicsOfRobots:
    """What came of all robots that were asked for; the diagnostics say what cannot be."""

    robots: list[CheckedPhysics]


ANSWERS: dict[str, Any] = {"check physics": PhysicsOfRobots}
