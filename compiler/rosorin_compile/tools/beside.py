"""Two processes for one robot: artifacts are made and proven in a second one too, where there is a second core.

The second is a copy of the first (fork), begun once the robot is known: it takes it for right and makes artifacts while
the first one holds the tree against the schema, and the robot against the rules. Each takes the next output of a list
when it is done with one, so that both end at about the same time. What the second one does not answer for, for whatever
reason, the first one makes.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path

try:
    import _pickle as pickle  # the parts in C, which do all here; with the others it takes another 4 ms
    import _signal as signal  # type: ignore[import-not-found]
except ImportError:
    import pickle  # type: ignore[no-redef]
    import signal

from ..diagnostics.progress import hide, step
from ..pipeline import Made, Maker, Task, make_one
from ..startup import system
from ..startup.again import loaded, loaded_too, marked_too, marks
from ..startup.cache import cache_refused, digest, refused_too
from ..startup.records import NamedTuple

# What takes long is begun first; the formats of artifacts by that, the longest first.
_LONG = ("mjcf", "urdf", "sdf", "srdf", "robot_model", "frames_picture", "frames")
_MOST = 200  # outputs: the number of one is a byte


class Answer(NamedTuple):
    """What became of the output of that number: the artifact, is it proven, its digest, the templates that were used.

    The digest is that of the bytes of the artifact; empty if there are none.
    """

    number: int
    made: Made
    proven: bool
    digest: str
    used: set[Path]


class TwoProcesses(Maker):
    """Makes the artifacts of one robot in two processes.

    ``proven`` are the outputs that were read back, by name, ``digests`` those of the artifacts, by file.
    ``marked``: the second one marks the whole tool too, for stamps.
    """

    def __init__(self, marked: bool) -> None:
        self.proven: set[str] = set()
        self.digests: dict[str, str] = {}
        self._marked = marked
        self._second: _Second | None = None

    def foresee(self, task: Task) -> None:
        """Begin, if there is a core for a second process, and anything to do."""
        threads = sys.modules.get("threading")  # a copy of a process has none of its threads, but their locks
        alone = threads is None or threads.active_count() == 1
        if task.outputs and sys.platform == "linux" and system.HAS_FORK and alone and system.cores() > 1:
            with suppress(OSError):  # there may be as many processes as there can be
                self._second = _Second(task, self._marked)

    def make(self, task: Task) -> tuple[list[Made], tuple[Path, ...]]:
        """Return the artifacts by the outputs, and the templates of the description that were used."""
        if self._second is None and len(task.outputs) > 1:  # the files of meshes had to be found first
            self.foresee(task)
        if self._second is None or self._second.task.robot is not task.robot:
            return super().make(task)
        answers = {answer.number: answer for answer in _made(task, self._second.todo())}
        answers.update({answer.number: answer for answer in self._second.answers()})
        left = [number for number in range(len(task.outputs)) if number not in answers]
        answers.update({answer.number: answer for answer in _made(task, left)})
        self.proven = {task.outputs[answer.number].name for answer in answers.values() if answer.proven}
        self.digests = {task.outputs[answer.number].file: answer.digest for answer in answers.values() if answer.digest}
        made = [answers[number].made for number in range(len(task.outputs))]
        used = set[Path]().union(*(answer.used for answer in answers.values()))
        if not used:
            return made, ()
        templates = task.templates()
        templates.used.update(used)
        return made, templates.read()

    def end(self) -> None:
        """Let the second process go, whatever it is at."""
        if self._second is not None:
            self._second.end()


def _made(task: Task, numbers: Iterable[int]) -> Iterator[Answer]:
    """Make the artifacts of some outputs, by their numbers, and hold each against the model."""
    numbers = iter(numbers)
    first = next(numbers, None)
    if first is None:  # then nobody needs what makes artifacts, and what they are held against
        return
    from ..formats.known import Known
    from ..meaning.agreement import agrees

    model, templates = Known(task.robot), task.templates()
    for number in chain((first,), numbers):
        output = task.outputs[number]
        step(f"making {output.file},", number, len(task.outputs))
        made = make_one(task, output, templates)
        step(f"proving {output.file},", number, len(task.outputs))
        proven = made.artifact is not None and agrees(task.robot, made.artifact, model)
        yield Answer(number, made, proven, _digest(made.artifact.text) if made.artifact else "", templates.used)


def _digest(text: str) -> str:
    with suppress(UnicodeEncodeError):  # that is told when it is to be written
        return digest(text.encode())
    return ""


class _Second:
    """The second process, and the list of what is to do, which both take from: a byte an output.

    Its answers wait in a file in memory, so that it need not wait for anybody who reads; where each of them ends, it
    tells by a pipe when it is done.
    """

    def __init__(self, task: Task, marked: bool) -> None:
        self.task = task
        _bury()
        self._held = _nameless()
        self._taken, listed = os.pipe()
        self._answers, answers = os.pipe()
        try:
            self._child = os.fork()
        except OSError:
            for handle in (self._held, self._taken, listed, self._answers, answers):
                os.close(handle)
            raise
        if self._child == 0:
            os.close(self._answers)  # else nobody would be told that the first process is gone
            _answer(task, self._taken, listed, self._held, answers, marked)
        os.close(listed)
        os.close(answers)

    def todo(self) -> Iterator[int]:
        """Yield what is to do, one after the other."""
        return _in_turn(self._taken)

    def answers(self) -> list[Answer]:
        """Return what the second process has made, once it is done; nothing if it did not come so far."""
        try:
            with open(self._answers, "rb", closefd=False) as opened:
                ends, refused, marked, files = pickle.load(opened)  # noqa: S301 - of a copy of this process, by a pipe
            places = zip([0, *ends], ends, strict=False)
            found = [pickle.loads(os.pread(self._held, end - start, start)) for start, end in places]  # noqa: S301
        except Exception:  # it ended before it had told all
            return []
        refused_too(refused)
        marked_too(marked)
        loaded_too(files)
        return found

    def end(self) -> None:
        """Stop the process if it still runs; nobody waits until the system has taken apart what it held."""
        for handle in (self._held, self._taken, self._answers):
            os.close(handle)
        with suppress(ProcessLookupError):  # where SIGCHLD is ignored it may be gone already
            os.kill(self._child, signal.SIGKILL)
        _ended.append(self._child)
        _bury()


def _nameless() -> int:
    """Return a file that has no name and is gone with its last handle: in memory, where this Python knows of such."""
    if hasattr(os, "memfd_create"):
        return os.memfd_create("answers")
    import tempfile

    handle, name = tempfile.mkstemp()
    Path(name).unlink()
    return handle


_ended: list[int] = []  # processes that are being taken apart


def _bury() -> None:
    """Forget the processes that are no more."""
    for child in tuple(_ended):
        try:
            is_gone = os.waitpid(child, os.WNOHANG)[0] == child
        except ChildProcessError:  # where SIGCHLD is ignored nobody has to ask
            is_gone = True
        if is_gone:
            _ended.remove(child)


def _in_turn(taken: int) -> Iterator[int]:
    """Yield what nobody has taken from the list."""
    while byte := os.read(taken, 1):
        yield byte[0]


def _answer(task: Task, taken: int, listed: int, held: int, answers: int, marked: bool) -> None:
    """Be the second process: list what is to do, make what nobody has taken, tell it, and end without a word."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        hide()
        os.write(listed, bytes(_order(task)))  # a pipe holds more without anybody who reads
        os.close(listed)
        _work(task, taken, held, answers, marked)
    finally:
        os._exit(0)


def _work(task: Task, taken: int, held: int, answers: int, all_marked: bool) -> None:
    """Make what nobody has taken, keep it, and tell where it is."""
    from ..project import tool_folders

    modules, *data = tool_folders()
    marked = marks([modules, *data] if all_marked else data)  # while the first process has rules to ask
    ends = []
    with open(held, "wb") as opened:
        for answer in _made(task, _in_turn(taken)):
            pickle.dump(answer, opened, protocol=5)
            ends.append(opened.tell())
    with open(answers, "wb") as opened:
        pickle.dump((ends, cache_refused(), marked, loaded(modules)), opened, protocol=5)


def _order(task: Task) -> list[int]:
    """Return the numbers of the outputs to be shared, what takes long first. Plug-ins run in the first process."""
    from ..formats import is_built_in

    rank = {name: place for place, name in enumerate(_LONG)}
    numbers = [number for number, output in enumerate(task.outputs[:_MOST]) if is_built_in(output.backend)]
    return sorted(numbers, key=lambda number: rank.get(task.outputs[number].backend, len(rank)))
