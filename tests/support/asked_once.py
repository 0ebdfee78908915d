"""What a process of tests asks of the installed tool only once: its sources for rules, its environment for plug-ins.

A run asks each time, as both may change between two runs. In a process of tests they do not: whoever changes them does
it elsewhere (a folder of its own on ``sys.path``, another process), and there all is asked as ever. So is all of which
notes are taken, since those are of what was read.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from rosorin_compile.source import plugins
from rosorin_compile.source import rule_registry as registry
from rosorin_compile.source.world.notes import are_open


def ask_once(patch: pytest.MonkeyPatch) -> None:
    """Let the rest of this process take the rules and the plug-ins of the environment as they are now."""
    declaring, declared_in, folders = registry._declaring, cache(registry.declared_in), plugins._metadata_folders
    path = tuple(sys.path)
    sources: list[tuple[Path, bytes]] = []
    installed: list[tuple[str, ...]] = []

    def declaring_once() -> Iterator[tuple[Path, bytes]]:
        if are_open():
            return declaring()
        if not sources:
            sources.extend(declaring())
        return iter(sources)

    def folders_once(entries: tuple[str, ...]) -> tuple[str, ...]:
        if are_open() or entries != path:
            return folders(entries)
        if not installed:
            installed.append(folders(entries))
        return installed[0]

    patch.setattr(registry, "_declaring", declaring_once)
    patch.setattr(registry, "declared_in", lambda source: list(declared_in(source)))
    patch.setattr(plugins, "_metadata_folders", folders_once)
