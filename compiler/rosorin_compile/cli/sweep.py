"""rosorin-compile sweep: compile one description for a list of variants, each into a folder of its own."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping
from contextlib import closing, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.language.arguments import Argument
from rosorin_compile.output import OutputError
from rosorin_compile.output.pipeline import Variant
from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import Diagnostic, and_more, counted, did_you_mean
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.version import __version__
from rosorin_compile.variants.compiling import (
    Job,
    Result,
    compile_variant,
    entry_of,
    from_json,
    input_digest,
    plain,
    state_digest,
)
from rosorin_compile.variants.folder import VariantsFolder
from rosorin_compile.variants.pool import compile_in_order, connect, cores
from rosorin_compile.variants.variants import Variants

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser

RULES = (
    Rule("variants-list", "A list of variants cannot be read.", "[Its form](sweep.md#the-list).", Heading.ARGUMENTS),
    Rule("variant-name", "A variant has no name of its own that a folder can have.", "", Heading.ARGUMENTS),
    Rule("variant-forgotten", "A note: a variant is not in the list any more.", "Use `--prune`.", Heading.WRITING),
    Rule("variant-outdated", "A warning: edited artifacts of a variant were replaced.", "", Heading.WRITING),
    Rule("output-busy", "Another run writes into the folder.", "Wait until it ends.", Heading.WRITING),
    Rule("worker-died", "The process that compiled a variant died, twice.", "Use a smaller `-j`.", Heading.WRITING),
    Rule("cluster-failed", "A Dask cluster cannot be used, or stopped.", "As the message says.", Heading.WRITING),
)
MAX_FAILED = 20  # variants whose errors are printed
_OF_VARIANT = ("output-not-ours", "output-in-the-way", "output-folder", "output-foreign", "output-name")


def options(command: Parser) -> None:
    """Add the options of the command."""
    over = "variants: a CSV file with a row for each, a YAML list, or a folder with a file of arguments for each"
    whole = "with a folder: argument to set to the content of each file, or to its path if it is a text"
    command.add_robot()
    command.add_argument("--over", required=True, type="path", metavar="LIST", completes="FILE", help=over)
    command.add_argument("-o", "--output", required=True, type="path", metavar="FOLDER", help="a folder per variant")
    command.add_argument("-j", "--jobs", type=int, metavar="NUMBER", help="number of processes; default: one per core")
    command.add_argument("--as", default="", dest="whole", metavar="ARGUMENT", help=whole)
    command.add_argument("--dask", metavar="ADDRESS", help="address of a Dask scheduler, such as tcp://HOST:8786")
    command.add_argument("--prune", action="store_true", help="delete variants that are no longer in the list")
    command.add_messages()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Compile the variants of a list; return the exit code."""
    how = "rosorin-compile sweep ROBOT --over FILE -o FOLDER"
    run, description = Run.alone(options, "a sweep is of one robot", how, "name a file")
    console, whole, code = run.console, options.whole, PROBLEMS
    console.begin(description.name)
    try:
        shared = run.given.values()
        declared, wrong = Argument.declared(description.path, shared, run.given.packages)
        types = {argument.name: argument.type for argument in declared}
        wrong = [problem for problem in wrong if problem.severity == "error"]
        home = description.path.parent if types.get(whole) == "text" else None
        variants = Variants(Path(options.over), list(types), whole, home)
        if options.jobs is not None and options.jobs < 1:
            raise WrongUsage("-j is 1 or more")
        if whole and not variants.is_folder:
            raise WrongUsage("--as goes with a folder of files, one per variant")
        if whole and whole not in types and not wrong:
            known = did_you_mean(whole, types) or "it has none"
            raise WrongUsage(f'{description.name} has no argument "{whole}"; {known}')
        wrong = wrong or variants.check()
        console.show(wrong)
        if wrong:
            console.warn(f"{options.over}: {counted(len(wrong), 'error')}, nothing written")
        else:
            placed = replace(description, outputs=Path(options.output))
            code = _Sweep(options, console, Job(placed, shared, run.given, state_digest()), variants).run()
    except (LoadError, OutputError) as problem:
        console.show([problem.diagnostic])
    console.end(code != FINE)
    console.finish()
    return code


class _Sweep:
    """One run of the command: its options and what it has counted."""

    def __init__(self, options: argparse.Namespace, console: Console, job: Job, variants: Variants) -> None:
        self.options, self.console, self.job, self.variants = options, console, job, variants
        self.folder, self.edited = VariantsFolder(job.description.outputs), 0
        self.counts = {"made": 0, "unchanged": 0, "error": 0}
        self.remarks: dict[str, tuple[str, int]] = {}  # by JSON: the first variant that has it, and how many have

    def run(self) -> int:
        """Compile all variants and write ``sweep.json``. Raises OutputError, LoadError."""
        try:
            cluster = closing(connect(self.options.dask)) if self.options.dask else nullcontext()
            with cluster as client, self.folder.opened():
                self._compile(client)
        except OSError as problem:
            raise OutputError.of(problem, self.folder.path, "write") from None
        except KeyboardInterrupt:
            done = f"{sum(self.counts.values()):,} of {counted(len(self.variants), 'variant')} done"
            self.console.warn(f"stopped: {done}; the same command continues from there")
            raise
        self._report()
        result = {"description": str(self.job.description.path), "folder": self.options.output, **self.counts}
        give_result(self.options, result, str)
        return PROBLEMS if self.counts["error"] else FINE

    def _compile(self, client: Any) -> None:
        head: dict[str, Any] = {"description": os.path.relpath(self.job.description.path, self.folder.path)}
        head |= {"arguments": plain(self.job.shared)} if self.job.shared else {}
        jobs, work = min(self.options.jobs or cores(), len(self.variants)), partial(compile_variant, self.job)
        with self.folder.index({"tool": __version__, **head}) as add:
            for variant, result in compile_in_order(self.variants, work, jobs, client, self._unchanged):
                entry = result if isinstance(result, dict) else self._write(variant, result)
                self.counts["unchanged" if result is entry else entry["status"]] += 1
                add(entry)
                self._show(entry)
                Progress.step("variants", sum(self.counts.values()), len(self.variants))
            self._forget()

    def _unchanged(self, variant: Variant) -> dict[str, Any] | None:
        """Return the entry of a variant that need not be compiled, or None."""
        record = self.folder.record(variant.name)
        if record["key"] != self.job.key(variant) or any(input_digest(p) != d for p, d in record["inputs"].items()):
            return None
        is_intact = self.folder.is_intact(variant.name, record["entry"]["artifacts"])
        self.edited += not is_intact
        return record["entry"] if is_intact else None

    def _write(self, variant: Variant, result: Result | Diagnostic) -> dict[str, Any]:
        """Write a variant that was compiled, and return its entry. Raises OutputError if nothing can be written."""
        if isinstance(result, Diagnostic):
            result = Result(entry_of(variant, [result], {}), {}, {})
        if result.entry["status"] == "error":
            self.folder.drop(variant.name)
            return result.entry
        record = {"key": self.job.key(variant), "inputs": result.inputs, "entry": result.entry}
        try:
            self.folder.put(variant.name, result.files, record)
        except OutputError as problem:
            if problem.diagnostic.rule not in _OF_VARIANT:
                raise
            return entry_of(variant, [problem.diagnostic], {})
        return result.entry

    def _show(self, entry: Mapping[str, Any]) -> None:
        """Print the errors of a variant at once; keep warnings and notes, of which many variants have the same."""
        for found in entry["diagnostics"]:
            if found["severity"] != "error":
                first, count = self.remarks.get(json.dumps(found), (entry["name"], 0))
                self.remarks[json.dumps(found)] = (first, count + 1)
            elif self.counts["error"] <= MAX_FAILED:
                self.console.show([from_json(found, entry["name"])])

    def _forget(self) -> None:
        """Remove the variants that are not in the list any more, or report them."""
        names = [name for name in self.folder.names() if name not in self.variants]
        for name in names if self.options.prune else ():
            self.folder.drop(name)
        count, shown = counted(len(names), "variant"), ", ".join(names[:5]) + and_more(len(names[5:]))
        if names and self.options.prune:
            self.console.say(f"{count} removed: {shown}")
        elif names:
            message = f"{count} of {self.folder.path} not in the list, and kept: {shown}"
            self.console.show([Diagnostic("variant-forgotten", "note", message, help="sweep --prune removes them")])

    def _report(self) -> None:
        for remark, (first, count) in self.remarks.items():
            self.console.show([from_json(json.loads(remark), f"{first}{and_more(count - 1)}")])
        if self.edited:
            message = f"{counted(self.edited, 'variant')} had edited or missing artifacts, and were written again"
            self.console.show([Diagnostic("variant-outdated", "warning", message, help="edit a copy elsewhere")])
        if self.counts["error"] > MAX_FAILED:
            self.console.warn(f"{self.counts['error'] - MAX_FAILED} more variants with errors: see sweep.json")
        for status, count in self.counts.items():
            self.console.say(f"{'errors' if status == 'error' else status:<9} {count:>10,}")
