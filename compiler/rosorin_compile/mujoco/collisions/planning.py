"""The robot as MoveIt plans with it: one URDF, and the matrix that its description includes.

``ros.srdf.planning`` implements it; the API passes it to ``compute_matrix``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

from rosorin_compile.model import DisabledCollision, Joint, Output, Robot, Shape

Pair = tuple[str, str]


class Parts(Protocol):
    """Digests of all that a verdict on a pair of links depends on: the search, shapes with meshes, joints."""

    @property
    def how(self) -> str:
        """That of the search."""

    @property
    def shapes(self) -> Mapping[str, str]:
        """Those of the shapes, by link."""

    @property
    def joints(self) -> Mapping[str, str]:
        """Those of the joints, by name."""


class Planning(Protocol):
    """A robot as MoveIt has it of one URDF; ``said`` is the section ``moveit``."""

    @property
    def robot(self) -> Robot:
        """The robot."""

    @property
    def urdf(self) -> Output:
        """The URDF that MoveIt reads."""

    @property
    def said(self) -> Any:
        """The section ``moveit`` of the description."""

    @property
    def links(self) -> Collection[str]:
        """The links of the URDF."""

    @property
    def joints(self) -> Mapping[str, Joint]:
        """The joints of the URDF by name."""

    @property
    def solids(self) -> Mapping[str, list[Shape]]:
        """The collision shapes of each link of the URDF that has any."""

    @property
    def digest(self) -> str:
        """What tells it from any other."""

    @property
    def meshes(self) -> Sequence[str]:
        """The names of the mesh files that collide, each once, sorted."""

    def digests(self, files: Mapping[str, Path]) -> dict[str, str]:
        """Return the digests of those of its mesh files that were found and can be read, by name."""

    def parts(self, meshes: Mapping[str, str]) -> Parts:
        """Return the digests of what decides on single pairs; ``meshes`` are those of mesh files, by name."""

    def same_pairs(self, now: Any) -> dict[Pair, DisabledCollision | None]:
        """Return the pairs of its matrix that are the same as then; None for one to be checked."""

    def between(self, base: str, tip: str) -> list[Joint]:
        """Return the joints of the URDF between two links."""


def ordered(pair: Pair) -> Pair:
    """Return two names in their order."""
    one, other = sorted(pair)
    return (one, other)
