"""The result of an engine that compared what was made of a robot with its source."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import NamedTuple


class Proof(NamedTuple):
    """How what was made of a source differs from it, in texts by feature.

    ``wrong`` was not reported before, ``known`` was. ``said`` is the sentence about what the engine has shown;
    ``unknown`` is why it did not answer, empty if it did. ``counts`` is the number of objects of the source by kind.
    """

    wrong: Mapping[str, Sequence[str]] = {}
    known: Mapping[str, Sequence[str]] = {}
    said: str = ""
    unknown: str = ""
    counts: Mapping[str, int] = {}

    @property
    def texts(self) -> list[str]:
        """All differences that were not reported before, feature by feature."""
        return [text for texts in self.wrong.values() for text in texts]


def sort_differences(
    differences: Iterable[tuple[str, str]], is_known: Callable[[str, str], bool]
) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """Return texts by feature: those that were not reported before, and those that were."""
    wrong: dict[str, list[str]] = {}
    known: dict[str, list[str]] = {}
    for feature, text in differences:
        (known if is_known(feature, text) else wrong).setdefault(feature, []).append(text)
    return wrong, known
