"""Compile the variants of a list, and return them or write each to a separate folder."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rosorin_compile.formats.compilation import CompileResult, Variant
from rosorin_compile.language.arguments import declared_arguments
from rosorin_compile.output.atomic_files import OutputError
from rosorin_compile.request import FilePath, Packages, Request, Values, Warn
from rosorin_compile.source import system
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, RequestError, UnknownName, error
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.version import __version__
from rosorin_compile.source.wording import and_more, count_of, first_of

from .folder import VariantsFolder
from .variants import Variants, python_variant
from .workers import Job, Result, compile_in_order, compile_only, compile_variant, connect, entry_of, from_json, plain

if TYPE_CHECKING:
    from distributed import Client

MAX_FAILED = 20  # maximum number of variants whose errors are printed
_OF_VARIANT = ("output-not-ours", "output-in-the-way", "output-folder", "output-foreign", "output-name")


def sweep(
    robot: FilePath | Request,
    variants: FilePath | Mapping[str, Any] | Iterable[Any],
    arguments: Values = None,
    packages: Packages = None,
    client: Client | None = None,
    *,
    trust: bool = False,
) -> Iterator[CompileResult]:
    """Compile a description with the arguments of each variant, without writing files.

    Args:
        variants: A CSV or YAML file or a folder as in ``sweep --over``, a mapping from names to arguments, an
            iterable of (name, arguments), or an iterable of arguments that include ``name``.
        arguments: Arguments of all variants; a variant can override them.
        client: A ``distributed.Client`` on whose cluster the variants are compiled.

    Yields:
        A ``CompileResult`` for each variant, in order; or a single result without a variant if the list has errors.

    Raises:
        OutputError: If the cluster fails.

    Example:
        >>> import rosorin_compile
        >>> variants = {"low": {"base": "fixed"}, "wrong": {"base": "tall"}}
        >>> for compiled in rosorin_compile.sweep("examples/unitree_a1", variants):
        ...     print(compiled.variant.name, compiled.robot)
        low <Robot unitree_a1: 23 links, 22 joints (12 that move), 5 sensors>
        wrong None
    """
    request = Request.from_arguments(robot, arguments, packages, trust=trust)
    if request.problems:
        yield request.compile()
        return
    values = request.values()
    listed: Iterable[Variant] = ()
    declared, wrong = declared_arguments(request.description.path, values, request.packages)
    wrong = [problem for problem in wrong if problem.severity == ERROR]
    if isinstance(variants, (str, os.PathLike)):
        listed = file = Variants(Path(os.fsdecode(variants)), [argument.name for argument in declared])
        wrong = wrong or file.check()
    elif isinstance(variants, Iterable):
        listed = map(python_variant, variants.items() if isinstance(variants, Mapping) else variants)
    else:
        wrong = [error("variants-list", f"variants are a file, a mapping or a list, not {variants!r}", None)]
    if wrong:
        yield CompileResult(None, (), wrong, ())
        return
    work = partial(compile_only, Job(replace(request, warn=None), values))
    for variant, made in compile_in_order(listed, work, client=client):
        yield CompileResult(None, (), [made], (), variant=variant) if isinstance(made, Diagnostic) else made


@dataclass(frozen=True)
class WrittenVariants:
    """The result of ``write_sweep``: the number of variants by status; `sweep.json` lists the variants.

    If the sweep stopped before the last variant, ``complete`` is False and ``diagnostics`` has the reason and
    the errors of the first variants. All errors are in `sweep.json`.
    """

    description: str
    folder: str
    made: int = 0
    unchanged: int = 0
    error: int = 0
    removed: Annotated[tuple[str, ...], "names of variants that were removed, with `--prune`"] = ()
    complete: bool = False
    diagnostics: tuple[Diagnostic, ...] = ()


def write_sweep(
    robot: FilePath | Request,
    variants: FilePath,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    jobs: int | None = None,
    whole: str = "",
    dask: str = "",
    prune: bool = False,
    report: Warn = None,
    trust: bool = False,
) -> WrittenVariants:
    r"""Compile a description with the arguments of each variant, and write each variant to a separate folder.

    The result has the number of variants by status. Variants that are up to date are not compiled again.

    Args:
        variants: A CSV or YAML file, or a folder with a file of arguments for each variant.
        folder: The folder for ``sweep.json`` and a subfolder per variant.
        arguments: Arguments of all variants; a variant can override them.
        jobs: The number of processes; by default one per core.
        whole: The argument whose value is the contents, or the path, of each file in the folder ``variants``.
        dask: The address of a Dask scheduler.
        prune: Remove variants that are no longer in the list.
        report: A function that is called with each diagnostic immediately.

    Example:
        >>> import rosorin_compile, tempfile
        >>> with open(tempfile.mkdtemp() + "/variants.csv", "w") as file:
        ...     _ = file.write("name,base\nlow,fixed\n")
        >>> result = rosorin_compile.write_sweep("examples/unitree_a1", file.name, tempfile.mkdtemp(), jobs=1)
        >>> result.made, result.error, result.complete
        (1, 0, True)
    """
    request = Request.from_arguments(robot, arguments, packages, trust=trust)
    over, folder = Path(os.fsdecode(variants)), Path(os.fsdecode(folder))
    if request.problems:
        return WrittenVariants(str(robot), str(folder), diagnostics=request.problems)
    if jobs is not None and jobs < 1:
        raise RequestError("the number of jobs is 1 or more")
    description, reported = request.description, list[Diagnostic]()

    def tell(diagnostic: Diagnostic) -> None:
        reported.append(diagnostic)
        if report is not None:
            report(diagnostic)

    result, writer = WrittenVariants(str(description.path), str(folder)), None
    try:
        shared = request.values()
        declared, wrong = declared_arguments(description.path, shared, request.packages)
        types = {argument.name: argument.type for argument in declared}
        wrong = [problem for problem in wrong if problem.severity == ERROR]
        listed = Variants(over, types, whole, description.path.parent if types.get(whole) == "text" else None)
        if whole and not listed.is_folder:
            raise RequestError("--as goes with a folder of files, one per variant")
        if whole and whole not in types and not wrong:
            raise UnknownName("argument", whole, types, description.name, "it has none")
        for problem in (wrong := wrong or listed.check()):
            tell(problem)
        if not wrong:
            placed = replace(request, description=replace(description, outputs=folder), warn=None)
            writer = _Writer(Job(placed, shared), listed, tell, prune)
            writer.run(jobs, dask)
            result = replace(result, removed=tuple(writer.removed), complete=True)
    except (LoadError, OutputError) as problem:
        tell(problem.diagnostic)
    counts: dict[str, Any] = writer.counts if writer else {}
    return replace(result, **counts, diagnostics=tuple(reported))


class _Writer:
    def __init__(self, job: Job, variants: Variants, tell: Callable[[Diagnostic], None], prune: bool) -> None:
        self.job, self.variants, self.tell, self.prune = job, variants, tell, prune
        self.folder, self.edited = VariantsFolder(job.request.description.outputs), 0
        self.counts = dict.fromkeys(("made", "unchanged", "error"), 0)
        self.removed: list[str] = []
        self.remarks: dict[str, tuple[str, int]] = {}  # JSON: (first variant, number of variants)

    def run(self, jobs: int | None, dask: str) -> None:
        path, shared = self.job.request.description.path, self.job.shared
        head: dict[str, Any] = {"tool": __version__, "description": os.path.relpath(path, self.folder.path)}
        head |= {"arguments": plain(shared)} if shared else {}
        work, jobs = partial(compile_variant, self.job), min(jobs or system.cores(), len(self.variants))
        try:
            cluster = closing(connect(dask)) if dask else nullcontext()
            with cluster as client, self.folder.hold(), self.folder.index(head) as add:
                for variant, result in compile_in_order(self.variants, work, jobs, client, self._unchanged):
                    entry = result if isinstance(result, dict) else self._write(variant, result)
                    self.counts["unchanged" if result is entry else entry["status"]] += 1
                    add(entry)
                    self._report(entry)
                    Progress.step("variants", sum(self.counts.values()), len(self.variants))
                gone = [name for name in self.folder.names() if name not in self.variants]
                for name in gone if self.prune else ():
                    self.folder.drop(name)
                    self.removed.append(name)
                if gone and not self.prune:
                    many, shown = count_of(len(gone), "variant"), first_of(gone, 5)
                    message = f"{many} of {self.folder.path} not in the list, and kept: {shown}"
                    self.tell(Diagnostic("variant-forgotten", NOTE, message, help="sweep --prune removes them"))
        except OSError as problem:
            raise OutputError.from_os_error(problem, self.folder.path, "write") from None
        except KeyboardInterrupt:
            done = f"{sum(self.counts.values()):,} of {count_of(len(self.variants), 'variant')} done"
            raise KeyboardInterrupt(done) from None
        for remark, (first, count) in self.remarks.items():
            self.tell(from_json(json.loads(remark), f"{first}{and_more(count - 1)}"))
        if self.edited:
            message = f"{count_of(self.edited, 'variant')} had edited or missing artifacts, and were written again"
            self.tell(Diagnostic("variant-outdated", WARNING, message, help="edit a copy elsewhere"))

    def _unchanged(self, variant: Variant) -> dict[str, Any] | None:
        record = self.folder.record(variant.name)
        if not self.job.is_current(variant, record):
            return None
        is_intact = self.folder.is_intact(variant.name, record["entry"]["artifacts"])
        self.edited += not is_intact
        return record["entry"] if is_intact else None

    def _write(self, variant: Variant, result: Result | Diagnostic) -> dict[str, Any]:
        if isinstance(result, Diagnostic):
            result = Result(entry_of(variant, [result], {}), {}, {})
        try:
            if result.entry["status"] == "error":
                self.folder.drop(variant.name)
            else:
                record = {"key": self.job.key(variant), "inputs": result.inputs, "entry": result.entry}
                self.folder.put(variant.name, result.files, record)
        except OutputError as problem:
            if problem.diagnostic.rule not in _OF_VARIANT:
                raise
            return entry_of(variant, [problem.diagnostic], {})
        return result.entry

    def _report(self, entry: Mapping[str, Any]) -> None:
        """Report the errors of a variant; collect warnings and notes, which many variants share, until the end."""
        for found in entry["diagnostics"]:
            if found["severity"] != ERROR:
                first, count = self.remarks.get(json.dumps(found), (entry["name"], 0))
                self.remarks[json.dumps(found)] = (first, count + 1)
            elif self.counts["error"] <= MAX_FAILED:
                self.tell(from_json(found, entry["name"]))
