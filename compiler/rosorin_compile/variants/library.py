"""Compile the variants of a list as values. Nothing is written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from rosorin_compile.formats.compiled import Compiled, Variant
from rosorin_compile.language.arguments import declared as declared_arguments
from rosorin_compile.language.arguments import from_python
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, Source, error
from rosorin_compile.source.tree import Map

from .compiling import Job, compile_only
from .pool import compile_in_order
from .variants import NAME, Variants, wrong_name


def compile_variants(request: Request, variants: Any, client: Any = None) -> Iterator[Compiled]:
    """Yield each variant of a description, compiled. Raises OutputError if the client fails."""
    values = request.values()
    listed: Iterable[Variant] = ()
    declared, wrong = declared_arguments(request.description.path, values, request.packages)
    wrong = [problem for problem in wrong if problem.severity == "error"]
    if isinstance(variants, (str, os.PathLike)):
        listed = file = Variants(Path(os.fsdecode(variants)), [argument.name for argument in declared])
        wrong = wrong or file.check()
    elif isinstance(variants, Iterable):
        listed = map(_variant, variants.items() if isinstance(variants, Mapping) else variants)
    else:
        wrong = [error("variants-list", f"variants are a file, a mapping or a list, not {variants!r}", None)]
    if wrong:
        yield Compiled(None, (), wrong, ())
        return
    work = partial(compile_only, Job(replace(request, warn=None), values))
    for variant, made in compile_in_order(listed, work, client=client):
        yield Compiled(None, (), [made], (), variant=variant) if isinstance(made, Diagnostic) else made


def _variant(entry: Any) -> Variant:
    """Return the variant of a pair of a name and arguments, or of arguments with a name among them."""
    if isinstance(entry, Mapping):
        name, arguments = entry.get(NAME, ""), {key: value for key, value in entry.items() if key != NAME}
    else:
        name, arguments = entry if isinstance(entry, (tuple, list)) and len(entry) == 2 else ("", entry)
    values, wrong = from_python({} if arguments is None else arguments)
    tree = Map(Source("variants", "").span())
    tree.update(values)
    variant = Variant(name if isinstance(name, str) else "", tree)
    return replace(variant, diagnostics=(*wrong, *wrong_name(variant)))
