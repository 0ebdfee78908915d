"""A motion without a direction is refused in one way, whatever the kind of joint."""

from __future__ import annotations

import pytest

from rosorin_compile.model.joint import motion, plane_axes


@pytest.mark.parametrize(
    ("kind", "position"), [("revolute", 1.0), ("continuous", 1.0), ("prismatic", 1.0), ("planar", (1.0, 1.0, 1.0))]
)
def test_a_zero_axis_is_no_direction(kind: str, position: float | tuple[float, ...]) -> None:
    with pytest.raises(ValueError, match="an axis that is not zero"):
        motion(kind, (0.0, 0.0, 0.0), position)


def test_a_plane_needs_a_normal() -> None:
    with pytest.raises(ValueError, match="an axis that is not zero"):
        plane_axes((0.0, 0.0, 0.0))
