"""Overlapping links of a robot, for the viewer; the scene is made for the first positions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.rules.case import Case

if TYPE_CHECKING:
    from .scene import Scene


class Touching:
    """One robot in MuJoCo; ``files`` are those of its meshes by name."""

    def __init__(self, case: Case, files: Mapping[str, Path]) -> None:
        self.case = case
        self.files = files
        self.scene: Scene | None = None

    def lacking(self) -> str:
        """Return what has to be installed for an answer, as pip has it; empty if nothing is missing."""
        from .checking import lacking

        return lacking()

    def pairs(self, positions: Mapping[str, Any]) -> list[list[str]]:
        """Return the pairs of links that overlap at positions by joint (rad or m), except neighbours.

        The position of a joint with several coordinates is a list.
        """
        if self.scene is None:
            self.scene = self._made()
        return [list(pair) for pair in self.scene.overlaps(positions) if self.scene.joint_of(pair) is None]

    def _made(self) -> Scene:
        from .files import Meshes
        from .scene import Scene

        return Scene(self.case.robot, Meshes(self.case, self.files))
