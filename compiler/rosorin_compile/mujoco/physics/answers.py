"""The result of check physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from rosorin_compile.source.diagnostics import Diagnostic, counted, has_errors, listed


@dataclass(frozen=True)
class LookedAt:
    """The extent of a check: zero and the poses, the joints that were moved over their ranges, the meshes."""

    poses: Annotated[int, "how many named poses; position zero comes on top"]
    joints: Annotated[int, "how many joints, each led over its range"]
    meshes: Annotated[int, "how many files of meshes"]

    def __str__(self) -> str:
        at = [f"the ranges of {counted(self.joints, 'joint')}"] if self.joints else []
        at += [counted(self.meshes, "mesh")] if self.meshes else []
        return listed([counted(self.poses, "pose"), "zero", *at] if self.poses else ["zero", *at])


@dataclass(frozen=True)
class CheckedPhysics:
    """The result of the check of one robot."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether there is no error; the exit code is 0 where all are fine"]
    looked_at: Annotated[LookedAt | None, "null if the description has errors"]
    diagnostics: tuple[Diagnostic, ...] = ()

    @classmethod
    def of(cls, robot: str, file: str, looked_at: LookedAt | None, diagnostics: Sequence[Diagnostic]) -> CheckedPhysics:
        """Return the result with these diagnostics."""
        return cls(robot, file, not has_errors(diagnostics), looked_at, tuple(diagnostics))
