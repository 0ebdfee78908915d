"""Worker: what runs on a worker of a cluster: a batch of variants, made of files that came along.

A worker needs no file of the project. It unpacks a bundle once, at the same paths below a folder of its own, and names
files in its messages as they are named where the sweep was asked for. It writes the artifacts itself where they go to
an address of fsspec, or where it sees the very folder of the run, as the same user; else they travel, compressed.
"""

from __future__ import annotations

import gc
import hashlib
import json
import os
import tempfile
import threading
import time
import zlib
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache, lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rosorin_compile import Variant, __version__
from rosorin_compile.diagnostics import Diagnostic, Related, has_errors
from rosorin_compile.extending import Description, Given, Holding, OutputError, tool_folders, world

from .folder import VariantsFolder
from .making import Folder, Job, Kept, Made, Maker, Row, compiled_here, line_of
from .remote import folder_of

if TYPE_CHECKING:
    from rosorin_compile import Compiled

_MISSING = ("file-unreadable", "package-missing", "template-missing", "include-outside")

Batch = list[tuple[int, Variant, dict[str, bytes]]]  # with the files that a variant alone has


class Bundle(NamedTuple):
    """What a description is made of, bytes by absolute path; ``named`` says how paths are shown here."""

    files: dict[str, bytes]
    first: str
    packages: dict[str, str]
    named: tuple[tuple[str, str], ...]
    key: str


class Answer(NamedTuple):
    """What a worker made: the line of the index, the artifacts (compressed), and the rows of what was read.

    ``lacking`` says that a file was looked for that may be here. Instead of files there is what became of the variant,
    where the worker has written them, or ``compiled`` for the library.
    """

    line: str
    files: dict[str, bytes]
    read: list[Row]
    lacking: bool
    made: Made | None = None
    compiled: Compiled | None = None


class Answers(NamedTuple):
    """What a worker made of a batch, in what time, and by which tool."""

    answers: list[tuple[int, Answer]]
    seconds: float
    tool: str


class Task(NamedTuple):
    """What is the same for all batches: arguments of all variants, whom to trust, and what is wanted of each.

    ``whole``: what was compiled, for the library; ``out``: that the artifacts are written there, if that can be; else
    that they come. ``run`` is the word by which a worker knows the folder of the run; ``key`` is that of the job,
    ``asked`` what was asked for a variant that was made at home.
    """

    shared: dict[str, Any]
    trust: bool
    tool: str
    whole: bool = False
    out: str = ""
    run: str = ""
    key: str = ""
    asked: tuple[Row, ...] = ()


_lock = threading.Lock()
_unpacked: dict[str, Path] = {}
_kept: dict[str, Kept] = {}


def work(bundle: Bundle, task: Task, batch: Batch) -> Answers:
    """Make a batch of variants; one batch at a time in a process. Another tool than the asker's makes nothing."""
    begun = time.perf_counter()
    answers: list[tuple[int, Answer]] = []
    if tool() == task.tool:
        # Not in the thread of dask, into which it looks a hundred times a second: that was 5 % of the work.
        with _lock, _output(task) as folder, ThreadPoolExecutor(1) as own:
            answers += own.map(partial(_answered, _unpack(bundle), bundle, task, folder), batch)
            _settle()
    return Answers(answers, time.perf_counter() - begun, tool())


def _answered(
    root: Path, bundle: Bundle, task: Task, folder: Folder | None, one: tuple[int, Variant, dict[str, bytes]]
) -> tuple[int, Answer]:
    """Make a variant, with its own files in their places meanwhile."""
    index, variant, files = one
    for name, data in files.items():
        _unpack_one(root, name, data)
    answer = _answer(root, bundle, task, folder, variant)
    for name in files:
        _within(root, name).unlink(missing_ok=True)
    return index, answer


@cache
def _settle() -> None:
    """Spare the garbage collector what is imported by now, much of it for dask: that was a fifth of the work."""
    gc.collect()
    gc.freeze()


@contextmanager
def _output(task: Task) -> Iterator[Folder | None]:
    """Yield where this worker writes artifacts, if it does; a next run waits until it has."""
    folder = _folder(task.out, task.run) if task.out else None
    if isinstance(folder, VariantsFolder):
        with folder.joined(task.run) as is_there:
            yield folder if is_there else None
    else:
        yield folder


@lru_cache(maxsize=1)
def _folder(out: str, run: str) -> Folder:  # noqa: ARG001 - it remembers what it saw in this run
    return folder_of(out)


def _answer(root: Path, bundle: Bundle, task: Task, folder: Folder | None, variant: Variant) -> Answer:
    packages = {name: _within(root, path) for name, path in bundle.packages.items()}
    nowhere = VariantsFolder(root / "outputs")
    first = _within(root, bundle.first)
    maker = Maker(Job(Description("", first, root), task.shared, packages, task.trust, task.key), nowhere)
    maker.kept = _kept.setdefault(bundle.key, maker.kept)
    if task.whole:
        return _whole(maker, root, bundle, variant)
    compiled = maker.compiled(variant)
    said = [*variant.diagnostics, *compiled.diagnostics]
    files: dict[str, bytes] = {}
    try:
        if not has_errors(said):
            files = compiled.files()
    except OutputError as problem:
        said.append(problem.diagnostic)
    line = _named(line_of(variant, {name: Holding.digest(data) for name, data in files.items()}, said), root, bundle)
    read = _read(root, compiled) if files else []
    lacking = _lacking(root, compiled, said)
    if folder is not None and not lacking:
        asked = [*task.asked, *read] if read and task.asked else []
        made = Maker(maker.job, folder).take(variant, line, files, asked)
        if made.line == line and made.fatal is None:  # else it is tried where the sweep was asked for
            return Answer(line, {}, [], False, made)
    return Answer(line, {name: _packed(data) for name, data in files.items()}, read, lacking)


@lru_cache(maxsize=100)
def _packed(data: bytes) -> bytes:
    """Compress an artifact; within a batch equal ones are one object, which travels once."""
    return zlib.compress(data, 1)


@cache
def tool() -> str:
    """Return what tells this tool from another: its version and the contents of its sources."""
    known = hashlib.sha256()
    for top in tool_folders().values():
        for path in world.matching(top, "**/*"):
            if world.kind(path) == world.FILE and "__pycache__" not in path.parts:
                known.update(path.name.encode() + hashlib.sha256(world.read(path)).digest())
    return f"{__version__} ({known.hexdigest()[:12]})"


def _unpack(bundle: Bundle) -> Path:
    """Return the folder below which the files of a bundle stand in this process."""
    if bundle.key in _unpacked and world.kind(_unpacked[bundle.key]) == world.FOLDER:
        return _unpacked[bundle.key]
    place = None
    with suppress(ImportError, ValueError):
        from distributed import get_worker

        place = get_worker().local_directory  # goes with the worker
    root = world.real(tempfile.mkdtemp(prefix="rosorin-compile-", dir=place))
    for name, data in bundle.files.items():
        _unpack_one(root, name, data)
    _unpacked[bundle.key] = root
    return root


def _unpack_one(root: Path, name: str, data: bytes) -> None:
    path = _within(root, name)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def _within(root: Path, name: str) -> Path:
    return root / name.lstrip("/")


def _read(root: Path, compiled: Compiled) -> list[Row]:
    """Return what the files hold that a variant was made of, as answers where the sweep was asked for."""
    inputs = [
        path for path in dict.fromkeys(compiled.inputs) if path.is_relative_to(root) and world.kind(path) == world.FILE
    ]
    with world.noting() as notes:
        for path in inputs:
            world.read(path)
    return [(question, f"/{Path(path).relative_to(root)}", said) for question, path, said in notes.rows()]


def _whole(maker: Maker, root: Path, bundle: Bundle, variant: Variant) -> Answer:
    """Return the same for the library, which wants what was compiled and no files."""
    job = maker.job
    compiled = compiled_here(job.description.path, Given(job.shared, (), job.packages), variant, maker.kept)
    lacking = _lacking(root, compiled, compiled.diagnostics)
    inputs = tuple(Path(_shown(str(path), root, bundle)) for path in compiled.inputs)
    said = [_moved(one, root, bundle) for one in compiled.diagnostics]
    resolved = tuple(
        one._replace(
            name=_shown(one.name, root, bundle),
            by=_shown(one.by, root, bundle),
            answer=_shown(one.answer, root, bundle),
        )
        for one in compiled.resolved
    )
    moved = replace(compiled, inputs=inputs, diagnostics=said, resolved=resolved)
    return Answer("", {}, [], lacking, compiled=moved)


def _lacking(root: Path, compiled: Compiled, said: Iterable[Diagnostic]) -> bool:
    """Say whether a file was looked for that is not here."""
    if any(path.is_relative_to(root) and not world.kind(path) for path in compiled.inputs):
        return True
    if compiled.meshes is not None and compiled.meshes.missing:
        return True
    return any(one.rule in _MISSING for one in said)


def _shown(text: str, root: Path, bundle: Bundle) -> str:
    """Return a text with paths as they are shown where the sweep was asked for."""
    relative = f"{os.path.relpath(root)}/"
    text = text.replace(relative, f"{root}/") if not relative.startswith("..") else text
    for path, shown in bundle.named:
        text = text.replace(f"{root}{path}", shown)
    return text.replace(f"{root}/", "/")


def _named(line: str, root: Path, bundle: Bundle) -> str:
    if root.name not in line:
        return line

    def through(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: through(one) for key, one in value.items()}
        if isinstance(value, list):
            return [through(one) for one in value]
        return _shown(value, root, bundle) if isinstance(value, str) else value

    entry = json.loads(line)
    return json.dumps({**entry, "diagnostics": through(entry["diagnostics"])})


Told = TypeVar("Told", Diagnostic, Related)


def _moved(diagnostic: Diagnostic, root: Path, bundle: Bundle) -> Diagnostic:
    """Return a diagnostic whose places are shown as they are where the sweep was asked for."""

    def moved(one: Told) -> Told:
        span = one.span
        if span is not None:
            path = _shown(span.source.path, root, bundle)
            one = replace(one, span=span._replace(source=span.source._replace(path=path)))
        return replace(one, message=_shown(one.message, root, bundle))

    made = moved(diagnostic)
    return replace(made, related=tuple(map(moved, made.related)), help=_shown(made.help, root, bundle))
