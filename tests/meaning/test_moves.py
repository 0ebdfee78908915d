"""Which links of a robot sit elsewhere than they did, seen from what both robots have, as far as numbers are known."""

from __future__ import annotations

from itertools import pairwise

import pytest

from rosorin_compile.compare.precision import Precision, exact, rounded
from rosorin_compile.model import Joint, Link, Pose, Robot
from rosorin_compile.viewer.overlay import moves

ROUGH = rounded(0.005, 0.0)


def chain(*links: str, step: float = 1.0) -> Robot:
    """Return a robot of which each link is fixed to the one before."""
    joints = (Joint(f"to_{child}", "fixed", parent, child, Pose((step, 0.0, 0.0))) for parent, child in pairwise(links))
    return Robot("r", tuple(map(Link, links)), tuple(joints))


@pytest.mark.parametrize(
    ("old", "new", "at"),
    [
        ("base arm hand", "base arm hand", 0.0),
        ("base arm hand", "world base arm hand", 1.0),
        ("world base arm hand", "base arm hand", -1.0),
        ("one base arm hand", "two base arm hand", 0.0),  # neither root is known
        ("one base arm hand", "two more base arm hand", 1.0),
        ("one", "two", 0.0),
    ],
)
def test_what_both_have_stays_where_it_was_below_other_roots(old: str, new: str, at: float) -> None:
    found = moves(chain(*old.split()), chain(*new.split()))
    assert {name for name, how in found.how.items() if how not in ("new", "removed")} == set()
    assert found.at.xyz == (at, 0.0, 0.0)


def test_a_root_that_hangs_below_another_known_link_is_where_it_was() -> None:
    """What hung on it, and carries it now, moved."""
    old, new = chain("base", "arm"), chain("world", "arm", "base")
    assert moves(old, new).how == {"world": "new", "arm": "moved"}


@pytest.mark.parametrize(
    ("printings", "how"), [((exact, exact), {"arm": "moved"}), ((ROUGH, exact), {}), ((exact, ROUGH), {})]
)
def test_a_link_moved_farther_than_the_digits_of_one_of_the_two_leave_open(
    printings: tuple[Precision, Precision], how: dict[str, str]
) -> None:
    assert moves(chain("base", "arm"), chain("base", "arm", step=1.004), precisions=printings).how == how
