"""Which tests a landing runs, and which belong to a tier of ``.ci/full``: what their marks say."""

import pytest

EXAMPLES = "fuzz"  # the tier that tries all examples of the properties


def tiers_of(item: pytest.Item) -> list[str | None]:
    """Return the tiers that a test belongs to: ``None`` is what every landing passes.

    A property belongs to a tier, too, which tries all of its examples.
    """
    own = [marker.args[0] for marker in item.iter_markers("tier")]
    own += [tier for tier, *cases in _landings(item) if _case(item).isdisjoint(cases)]
    return own or [None, *[EXAMPLES] * is_property(item)]


def is_property(item: pytest.Item) -> bool:
    """Say whether hypothesis draws the examples of a test."""
    return getattr(getattr(item, "obj", None), "is_hypothesis_test", False)


def _landings(item: pytest.Item) -> list[tuple[str, ...]]:
    return [marker.args for marker in item.iter_markers("landing")]


def _case(item: pytest.Item) -> set[str]:
    case: str = item.callspec.id  # type: ignore[attr-defined]
    return {case, *case.split("-")}
