"""Meshes as extract takes them: the box around their triangles, and whether they were drawn in millimetres."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "mesh-looks-like-millimetres",
        "A warning: a mesh is longer than any part of a robot.",
        "`--scale 0.001`.",
        Heading.MESHES,
    ),
)

# No part of a robot is longer, in metres; one that is was drawn in millimetres.
LONGEST_PART = 20.0


def too_large(mesh: TriangleMesh) -> list[Diagnostic]:
    """Return a warning if a mesh is longer than any part of a robot: then it was drawn in millimetres."""
    lower, upper = bounds(mesh.triangles)
    longest = float((upper - lower).max())
    if longest <= LONGEST_PART:
        return []
    message = f"{mesh.name} is {longest:g} m long; that looks like millimetres"
    help = "--scale 0.001 turns millimetres into metres"
    return [Diagnostic("mesh-looks-like-millimetres", WARNING, message, None, (), help)]


def bounds(triangles: Floats) -> tuple[Floats, Floats]:
    """Return the lower and the upper corner (3,) of the axis-aligned box around triangles (n, 3, 3)."""
    return triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
