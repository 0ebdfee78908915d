"""``rosorin_compile.sweep``: the compiled variants as values. Nothing is written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile import Compiled, Variant
from rosorin_compile.diagnostics import Diagnostic, Source, error
from rosorin_compile.extending import Argument, Given, Map, OutputError, world

from .compiling import Job, compile_only
from .pool import compile_in_order
from .variants import NAME, Variants, wrong_name

if TYPE_CHECKING:
    from distributed import Client


def sweep(
    path: str | os.PathLike[str],
    variants: str | os.PathLike[str] | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    client: Client | None = None,
) -> Iterator[Compiled]:
    """Yield each variant of a description, compiled; see ``rosorin_compile.sweep``."""
    description, given, wrong = Given.asked(path, arguments, packages)
    if description is None:
        yield Compiled(None, (), wrong, ())
        return
    shared = given.values()
    declared, wrong = Argument.declared(description.path, shared, given.packages)
    listed, wrong_list = _listed(variants, [argument.name for argument in declared])
    wrong = [one for one in wrong if one.severity == "error"] or wrong_list
    if wrong:
        yield Compiled(None, (), wrong, ())
        return
    work = partial(compile_only, Job(description, shared, given, world.here()))
    try:
        for variant, made in compile_in_order(listed, work, client=client):
            is_dead = isinstance(made, Diagnostic)
            yield Compiled(None, (), [made], (), variant=variant) if is_dead else made
    except OutputError as problem:  # of a cluster
        yield Compiled(None, (), [problem.diagnostic], ())


def _listed(variants: Any, arguments: list[str]) -> tuple[Iterable[Variant], list[Diagnostic]]:
    """Return the variants, and the errors in the list as a whole."""
    if isinstance(variants, (str, os.PathLike)):
        listed = Variants(Path(os.fsdecode(variants)), arguments)
        return listed, listed.check()
    if isinstance(variants, Iterable):
        entries = variants.items() if isinstance(variants, Mapping) else variants
        return map(_variant, entries), []
    kind = type(variants).__name__
    message = f"variants are a file, a mapping of names to arguments, or a list of entries, not of the type {kind}"
    return (), [error("variants-list", message, None)]


def _variant(entry: Any) -> Variant:
    """Return the variant of a pair of a name and arguments, or of arguments with a name among them."""
    if isinstance(entry, Mapping):
        name, arguments = entry.get(NAME, ""), {key: value for key, value in entry.items() if key != NAME}
    else:
        name, arguments = entry if isinstance(entry, (tuple, list)) and len(entry) == 2 else ("", entry)
    given, wrong = Given.of(arguments)
    values = Map(Source("variants", "").start())
    values.update(given.values())
    variant = Variant(name if isinstance(name, str) else "", values)
    return replace(variant, diagnostics=(*wrong, *wrong_name(variant)))
