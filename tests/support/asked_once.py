"""What a process of tests asks of the installed tool only once: which rules its sources declare."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from rosorin_compile.source import rule_registry as registry


def ask_once(patch: pytest.MonkeyPatch) -> None:
    """Let the rest of this process take the rules of the tool as they are now."""
    declaring, declared_in = registry._declaring, cache(registry.declared_in)
    sources: list[tuple[Path, bytes]] = []

    def declaring_once() -> Iterator[tuple[Path, bytes]]:
        if not sources:
            sources.extend(declaring())
        return iter(sources)

    patch.setattr(registry, "_declaring", declaring_once)
    patch.setattr(registry, "declared_in", lambda source: list(declared_in(source)))
