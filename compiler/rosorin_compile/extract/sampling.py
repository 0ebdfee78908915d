"""Samples of a surface: a lattice on each triangle that reaches from corner to corner, edges included.

An edge is divided into so many pieces that neighbouring samples are at most a spacing apart. Each point of the surface
then has a sample within spacing / sqrt(3): the largest distance from the corners of a triangle whose edges are no
longer than the spacing.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]

# Into how many pieces an edge is divided: the next of these.
DIVISIONS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
MORE_DIVISIONS = (*DIVISIONS, 48, 64, 96, 128, 192)
# Points that are held in memory at once.
MOST_POINTS = 300_000


def divisions_needed(triangles: Floats, spacing: float, steps: tuple[int, ...] = DIVISIONS) -> Ints:
    """Return for each triangle (n, 3, 3) which of ``steps`` divides its edges enough; len(steps): none."""
    import numpy as np

    which: Ints = np.searchsorted(steps, longest_edge(triangles) / spacing * (1 - 1e-12))
    return which


def samples(triangles: Floats, which: Ints, steps: tuple[int, ...] = DIVISIONS) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Yield samples of triangles (n, 3, 3) that are divided as ``which`` (n,) says, in arrays of bounded length.

    Each time: which triangles (k,), for each point its position in that list (m,), and the points (m, 3). Triangles for
    which no step is enough are left out.
    """
    import numpy as np

    for index, divisions in enumerate(steps):
        (alike,) = (which == index).nonzero()
        weights = lattice(divisions)
        at_once = max(1, MOST_POINTS // len(weights))
        for start in range(0, len(alike), at_once):
            some = alike[start : start + at_once]
            corners = triangles if len(some) == len(triangles) else triangles[some]
            points = corners if divisions == 1 else np.matmul(weights, corners)
            yield some, np.repeat(np.arange(len(some)), len(weights)), points.reshape(-1, 3)


def longest_edge(triangles: Floats) -> Floats:
    """Return the length of the longest edge of each triangle (n,)."""
    import numpy as np

    longest = np.zeros(len(triangles))
    for first, second in ((0, 1), (1, 2), (2, 0)):
        edge = triangles[:, second] - triangles[:, first]
        np.maximum(longest, np.einsum("ij,ij->i", edge, edge), out=longest)
    return np.sqrt(longest)


@lru_cache(maxsize=32)
def lattice(divisions: int) -> Floats:
    """Return the weights (m, 3) of the corners for each point of the lattice on a triangle."""
    import numpy as np

    shares = [(a, b, divisions - a - b) for a in range(divisions + 1) for b in range(divisions + 1 - a)]
    weights: Floats = np.array(shares, dtype=np.float64) / divisions
    return weights
