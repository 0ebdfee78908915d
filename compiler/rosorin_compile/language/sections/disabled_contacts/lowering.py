"""The section ``disabled_contacts`` of a description as a value of the model: pairs of names of links."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...lower.entries import Problem


def pairs_of(tree: Mapping[str, Any], _: Problem) -> tuple[tuple[str, str], ...]:
    """Return the pairs; all that can be wrong with one is told by rules."""
    return tuple((pair["links"][0], pair["links"][1]) for pair in tree["disabled_contacts"])
