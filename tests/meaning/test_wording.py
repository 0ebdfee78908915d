"""What became of numbers, shapes, texts and pairs in words: as well as it is known, and not at any length."""

from __future__ import annotations

import pytest

from rosorin_compile.formats.facts import Solid
from rosorin_compile.meaning.shape_wording import numbers_change
from rosorin_compile.meaning.solids import Delta, largest_step, pieces_of, seen, shape_of, solid_from
from rosorin_compile.meaning.text_values import differing
from rosorin_compile.meaning.tolerance import EXACT, Placed
from rosorin_compile.meaning.wording import About, contacts_change
from rosorin_compile.model import Box, Ellipsoid, Pose, Shape, Transform

BOX = Shape(Box((-0.1, -0.2, -0.3), (0.1, 0.2, 0.3)), Pose((1.0, 0.0, 0.0), (0.1, 0.0, 0.0)))
ABOUT = About("arm", "collision")


def solid(pose: Pose, length: float = 0.0) -> Solid:
    return solid_from(Shape(BOX.geometry, pose))._replace(tolerance=length)


@pytest.mark.parametrize(
    ("other", "length", "told"),
    [
        (Pose((1.0, 0.0, 0.002), (0.1, 0.0, 0.0)), 0.0, "arm collision: box moved 2.0 mm (origin z 0 -> 0.002 m)"),
        (
            Pose((1.0, 0.0, 0.002), (0.2, 0.0, 0.0)),
            0.001,
            "arm collision: box moved 2.0 mm and turned 5.7 deg (origin z 0 -> 0.002 m, roll 0.1 -> 0.2 rad)",
        ),
        (
            Pose((1.0, 0.0, 0.002), (0.2, 0.0, 0.0)),
            0.01,  # as far as is known it did not move
            "arm collision: box turned 5.7 deg (roll 0.1 -> 0.2 rad)",
        ),
    ],
)
def test_a_shape_moved_as_far_as_that_is_known(other: Pose, length: float, told: str) -> None:
    (sentence,) = numbers_change(ABOUT, solid(BOX.pose, length), solid(other, length))
    assert str(sentence) == told


def test_no_angle_jumps_by_a_full_turn() -> None:
    one, other = (solid(Pose(rpy=(angle, 0.3, 0.0))) for angle in (3.1, -3.1))
    (sentence,) = numbers_change(ABOUT, one, other)
    assert str(sentence) == "arm collision: box turned 4.8 deg (roll 3.1 -> 3.18319 rad)"


def test_an_ellipsoid_is_a_shape_again() -> None:
    shape = Shape(Ellipsoid((0.1, 0.2, 0.3)), Pose((1.0, 0.0, 0.0)))
    assert shape_of(solid_from(shape)) == shape


def test_a_solid_is_known_no_better_than_the_place_from_which_it_is_seen() -> None:
    (piece,) = pieces_of("arm", [BOX], EXACT)
    assert seen(piece, Placed(Transform(), 0.01, 0.0)).solid.tolerance == pytest.approx(0.01)
    assert seen(piece, Placed(Transform(), 0.01, 0.02)).solid.tolerance == pytest.approx(0.01 + 0.02 * 1.0)


def test_of_many_values_the_first_are_told_and_the_number_of_the_others() -> None:
    old, new = ("\n".join(f"at {letter} {value}" for letter in "abcdef") for value in (1, 2))
    assert differing(old, new) == "line 1 at 1 -> 2, line 2 at 1 -> 2, line 3 at 1 -> 2, and 3 more"
    assert differing(old, old) == ""


def test_of_many_pairs_the_first_are_told_and_the_number_of_the_others() -> None:
    pairs = [f"link{at} - arm" for at in range(20)]
    text = str(contacts_change(pairs, pairs[:1]))
    named = sum(pair in text for pair in pairs)
    assert f", {len(pairs) - named} more)" in text
    assert text.startswith("excluded contacts: 20 new (")
    assert text.endswith(", 1 removed (link0 - arm)")


def test_a_solid_that_moved_did_so_by_one_length() -> None:
    one, other = (solid(Pose((x, 0.0, 0.0))) for x in (0.0, 0.25))
    assert largest_step(Delta((one,), (other,))) == largest_step(Delta((other,), (one,))) == pytest.approx(0.25)
