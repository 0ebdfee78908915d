"""Compile the variants of a list as values. Nothing is written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.compilation import Compiled, Variant
from rosorin_compile.language.arguments import declared_arguments as declared_arguments
from rosorin_compile.language.arguments import from_python
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.source.diagnostics import Diagnostic, Source, error
from rosorin_compile.source.tree import Map

from .compiling import Job, compile_only
from .pool import compile_in_order
from .variants import NAME, Variants, wrong_name

if TYPE_CHECKING:
    from distributed import Client


def sweep(
    robot: FilePath | Request,
    variants: FilePath | Mapping[str, Any] | Iterable[Any],
    arguments: Values = None,
    packages: Packages = None,
    client: Client | None = None,
    *,
    trust: bool = False,
) -> Iterator[Compiled]:
    """Compile a description with the arguments of each variant; nothing is written.

    Args:
        variants: A CSV or YAML file or a folder as in ``sweep --over``, arguments by name, or an iterable of pairs of a
            name and arguments or of tables with ``name`` among the arguments.
        arguments: Arguments of all variants, which those of a variant override.
        client: A ``distributed.Client`` on whose cluster the variants are compiled.

    Yields:
        A ``Compiled`` for each variant, in order; errors in the list itself are one ``Compiled`` without a variant.

    Raises:
        OutputError: The cluster fails.

    Example:
        >>> import rosorin_compile
        >>> variants = {"low": {"base": "fixed"}, "wrong": {"base": "tall"}}
        >>> for compiled in rosorin_compile.sweep("examples/unitree_a1", variants):
        ...     print(compiled.variant.name, compiled.robot)
        low <Robot unitree_a1: 23 links, 22 joints (12 that move), 5 sensors>
        wrong None
    """
    request = Request.of(robot, arguments, packages, trust=trust)
    if request.problems:
        yield request.compile()
        return
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
