"""Library: ``rosorin_compile.sweep``, for people who want numbers of many robots and not files."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile import Compiled, Variant
from rosorin_compile.diagnostics import Diagnostic, error
from rosorin_compile.extending import Argument, Given

from .making import Kept, compiled_here
from .variants import NAME, Variants, given, wrong_name

if TYPE_CHECKING:
    from distributed import Client


def sweep(
    path: str | os.PathLike[str],
    variants: str | os.PathLike[str] | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    client: Client | None = None,
) -> Iterator[Compiled]:
    """Yield what becomes of a description with the arguments of each variant: what the public verb says."""
    description, asked, wrong = Given.asked(path, arguments, packages)
    if description is None:
        yield Compiled(None, (), wrong, ())
        return
    first = description.path
    known, told = Argument.declared(first, asked.values(), asked.packages)
    listed, wrong = _listed(variants, [argument.name for argument in known])
    wrong = [one for one in told if one.severity == "error"] or wrong
    if wrong:
        yield Compiled(None, (), wrong, ())
    elif client is not None:
        from .cluster import compiled_on

        yield from compiled_on(client, first, asked, listed)
    else:
        kept: Kept = {}
        for variant in listed:
            yield compiled_here(first, asked, variant, kept)


def _listed(variants: Any, arguments: list[str]) -> tuple[Iterable[Variant], list[Diagnostic]]:
    """Return the variants that are asked for, and what is wrong with their list as a whole."""
    if isinstance(variants, (str, os.PathLike)):
        listed = Variants(Path(os.fsdecode(variants)), arguments)
        return listed, listed.check()
    if isinstance(variants, Mapping):
        return _checked(given(variants.items(), "variants")), []
    if isinstance(variants, Iterable):
        return _checked(given(map(_pair, variants), "variants")), []
    message = (
        f"variants are a file, arguments by name, or a list of them; this is of the type {type(variants).__name__}"
    )
    return (), [error("variants-list", message, None)]


def _pair(entry: Any) -> tuple[Any, Any]:
    """Return the name and the arguments of an entry of a list."""
    if isinstance(entry, Mapping):
        return entry.get(NAME, ""), {key: value for key, value in entry.items() if key != NAME}
    if isinstance(entry, (tuple, list)) and len(entry) == 2:
        return entry[0], entry[1]
    return "", entry


def _checked(variants: Iterable[Variant]) -> Iterator[Variant]:
    """Yield variants, those without a name that can be one with an error."""
    for variant in variants:
        name = variant.name if isinstance(variant.name, str) else ""
        named = replace(variant, name=name)
        yield replace(named, diagnostics=(*variant.diagnostics, *wrong_name(named)))
