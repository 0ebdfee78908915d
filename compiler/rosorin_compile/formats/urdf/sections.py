"""The sections of the language that have elements of their own in a URDF, where an output asks for them by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rosorin_compile.model import Output
from rosorin_compile.model.sections import OwnSection, own_sections


def sections_in(output: Output) -> Iterator[OwnSection[Any]]:
    """Yield the sections of which a URDF has elements."""
    for section in own_sections().values():
        if section.in_urdf and output.options.get(section.name):
            yield section
