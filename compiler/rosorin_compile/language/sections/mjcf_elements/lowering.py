"""The section ``mjcf_elements``, lowered: texts stay as they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...lower.entries import Problem


def mjcf_elements_of(tree: Mapping[str, Any], _: Problem) -> tuple[str, ...]:
    """Return the sections of MJCF that are kept as they are."""
    return tuple(tree["mjcf_elements"])
