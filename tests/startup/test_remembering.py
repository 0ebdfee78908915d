"""Remembering: each result is worked out once, until all are forgotten."""

from __future__ import annotations

from rosorin_compile.startup.remembering import forget, remembered


def test_each_result_is_worked_out_once_until_all_are_forgotten() -> None:
    asked: list[int] = []

    @remembered
    def doubled(number: int) -> int:
        """Return twice a number."""
        asked.append(number)
        return 2 * number

    assert [doubled(1), doubled(2), doubled(1)] == [2, 4, 2]
    assert asked == [1, 2]
    assert doubled.__doc__ == "Return twice a number."
    forget()
    assert doubled(1) == 2
    assert asked == [1, 2, 1]
