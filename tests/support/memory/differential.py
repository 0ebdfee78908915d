"""Steps: a random change of a world, then the program with memory twice and without; both answers have to be equal."""

from __future__ import annotations

import posixpath
import random
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from unittest import mock

from rosorin_compile import world
from rosorin_compile.startup.remembering import forget
from rosorin_compile.world import Notes, memory, noting, spoil
from rosorin_compile.world.disk import FILE, FOLDER, OTHER, behind

from . import plugin
from .program import PATHS, Program
from .values import SECOND, Values

OUT = "/out/r"
NAMES = ("a", "b", "c", "d")
STARTS = ("/r", "/", "/p", "/out")
FOLDERS = ("/r", "/r/a", "/r/b", "/p", "/q", "/p/a", "/q/a", "/q/b")
VARIABLES = (PATHS, "X", "Y")
ANSWERED, CHANGED, APPEARED = "answered from memory", "something read changed", "something looked for appeared"


class Wrong(AssertionError):
    """The answer with memory is another one than that without."""


@dataclass
class Answer:
    """What a run comes to: its exit code, its words, and what stands in the folder of artifacts."""

    code: int
    words: list[str]
    files: dict[str, bytes] = field(default_factory=dict)


class Differential:
    """A world with its memory; ``counts`` says how many steps were of which kind."""

    def __init__(self, seed: int, world: Values | None = None) -> None:
        self.chance = random.Random(seed)  # noqa: S311 - the same steps each time
        self.world = world or Values(self.chance.choice((1, 4_000_000, SECOND)))
        self.store: dict[str, bytes] = {}
        self.told = Notes()  # of the last run, or of the one that was remembered
        self.counts: Counter[str] = Counter()
        self.first = "/r/robot"
        self.named = self.first  # as it is seen from the folder that the run starts in
        self.disturbed = False
        self._begin()

    def _begin(self) -> None:
        for folder in ("/r", "/p", "/q", "/out", OUT, "/r/a", "/p/a"):
            self.world.make(folder, FOLDER)
        self.world.write(self.first, b"include b\nmesh c\nfind a\nenv X\nlist a\nplug rules\n")
        self.world.write("/p/robot", b"mesh a\nglob b\n")
        self.world.write("/r/b", b"link d\nreal a\nglob d\n")
        self.world.write("/r/c", b"texture d\nmesh")
        self.world.variables[PATHS] = "/p:/q"
        self._install()
        self.world.tick(10 * SECOND + 1)

    def step(self) -> None:
        """Change something, and ask with and without memory. Raises Wrong."""
        happened = self._changed(self.chance.choice((CHANGED, APPEARED, APPEARED)))
        if self.chance.random() < 0.1:
            self._go()
        self.world.tick(self.chance.choice((0, 1, 5_000_001, SECOND, 3 * SECOND + 7)))
        self.disturbed = self.chance.random() < 0.05
        known = False
        for _ in range(2):
            known = self._ask()
            self.world.tick(self.chance.choice((0, 2 * SECOND + 3)))
        self.counts.update(happened)
        self.counts[ANSWERED] += known

    def _changed(self, wish: str) -> set[str]:
        """Change something until what is wished for has come to pass, or some times; return what has."""
        happened: set[str] = set()
        for _ in range(self.chance.randint(1, 6)):
            self._change(wish)
            happened = self._happened()
            if wish in happened:
                break
        return happened

    def _happened(self) -> set[str]:
        """Return what has come to pass since the last run: what it was told is answered otherwise now."""
        asked = list(self.world.asked)
        with behind(self.world):
            now = memory.answers_now(self.told)
        self.world.asked[:] = asked
        before = self.told.answers.items()
        return {
            APPEARED if _is_none(kind, told) else CHANGED
            for ((kind, _), told), after in zip(before, now, strict=True)
            if after != told
        }

    def _go(self) -> None:
        """Start from another folder, and name the file, or the one of that name which stands there, if there is one."""
        self.world.folder = self.chance.choice(STARTS)
        relative = posixpath.relpath(self.first, self.world.folder)
        self.named = self.chance.choice((self.first, relative, "robot"))

    def _during(self) -> None:
        """Change a file in the midst of a run."""
        read = [path for how, path, there in self.world.asked if how == "read" and there]
        if read:
            self.world.write(self.chance.choice(read), self._text())

    def _ask(self) -> bool:
        del self.world.asked[:]
        done, was_known = self.with_memory()
        self.world.during, self.disturbed = None, False
        asked = list(self.world.asked)
        forget_before = mesh_results()
        expected = self.without()
        forget_before()
        self.world.asked[:] = asked or self.world.asked
        got = Answer(done.code, [text for _, text in done.said], self.world.folder_of(OUT))
        if was_known and (got.code, got.words) != (expected.code, expected.words):
            raise Wrong(f"{got.code} {got.words}, and not {expected.code} {expected.words}")
        if was_known and not expected.code and got.files != expected.files:
            raise Wrong(f"{got.files}, and not {expected.files}")
        return was_known

    def with_memory(self) -> tuple[memory.Done, bool]:
        def work() -> int:
            if self.disturbed:
                self.world.reads, self.world.during = self.chance.randint(1, 4), self._during
            program = Program()
            program.run(self.named)
            made = "\n".join(program.made).encode()
            if not program.failed:
                self.world.make(OUT, FOLDER)
                self.world.write(f"{OUT}/artifact", made)
                if self.world.folder_of(OUT).get("artifact") != made:
                    spoil("writers look for themselves what stands in their way")
                others = [name for name in self.world.folder_of(OUT) if name != "artifact"]
                world.note_written(OUT, {"artifact": made}, others)
            self._say(program.said)
            return int(program.failed)

        def hear(said: Sequence[str]) -> None:
            for one in said:
                memory.hear(memory.OUT, one)

        self._hear = hear
        with behind(self.world), self._kept(), self.world.process(), noting() as self.told:
            return memory.once(memory.line(["program", self.named]), work, [OUT])

    def _say(self, said: Sequence[str]) -> None:
        """Say what a run has to say, and what else stands among the artifacts, as writers look for themselves."""
        others = sorted(name for name in self.world.folder_of(OUT) if name != "artifact")
        self._hear([*said, *(f"{name} is kept" for name in others)])

    def without(self) -> Answer:
        """Return what a run comes to that knows nothing."""
        forget()
        words: list[str] = []
        self._hear = words.extend
        program = Program()
        with behind(self.world), self.world.process():
            program.run(self.named)
        self._say(program.said)
        files = self.world.folder_of(OUT)
        if not program.failed:
            files["artifact"] = "\n".join(program.made).encode()
        return Answer(int(program.failed), words, files)

    @contextmanager
    def _kept(self) -> Iterator[None]:
        with (
            mock.patch.object(memory, "private_folder", return_value="/store"),
            mock.patch.object(memory, "recalled", self.store.get),
            mock.patch.object(memory, "keep", self.store.__setitem__),
            mock.patch.object(memory, "SMALL", 24),
        ):
            yield

    # Changes.

    def _change(self, wish: str) -> None:
        asked = [(how, path) for how, path, there in self.world.asked if there == (wish == CHANGED)]
        if not asked and wish == APPEARED and self.chance.random() < 0.7:
            self._restore()
            return
        if not asked or self.chance.random() < 0.25:
            self._anything()
            return
        how, path = self.chance.choice(asked)
        if wish == APPEARED:
            self._appear(path, how)
        elif path.startswith("/r/robot") and self.chance.random() < 0.8:
            self.world.write(path, self._text(), self.chance.random() < 0.5)
        else:
            self._alter(path)

    def _appear(self, path: str, how: str) -> None:
        self.world.make(posixpath.dirname(path), FOLDER)
        if how == "status" and self.chance.random() < 0.6:
            self.world.make(path, FOLDER)
        elif self.chance.random() < 0.2:
            self.world.make(path, "link", self.chance.choice(("a", "../r/b", "/p/a", "c")))
        else:
            self.world.write(path, self._text())

    def _alter(self, path: str) -> None:
        chance = self.chance.random()
        node = self.world.nodes.get(path)
        if node is not None and node.kind == "link":
            self.world.remove(path)
            self.world.make(path, "link", self.chance.choice(("a", "b", "./a", "/p/a", "../q")))
        elif chance < 0.5 and node is not None and node.kind == FILE:
            # the same size, so that times alone could tell it
            data = bytearray(node.data or b"x")
            data[-1] = self.chance.choice(b"xyz")
            self.world.write(path, bytes(data), self.chance.random() < 0.7)
        elif chance < 0.7 and node is not None and node.kind == FOLDER:
            self.world.write(f"{path}/{self.chance.choice(NAMES)}", self._text())
        elif chance < 0.8 and path not in ("/r", "/r/robot", OUT, "/out"):
            self.world.remove(path)
        elif chance < 0.9:
            self.world.move(path, self._place())
        else:
            self.world.write(path, self._text(), self.chance.random() < 0.5)

    def _anything(self) -> None:
        change: Callable[[], None] = self.chance.choice(
            (
                self._variable,
                self._variable,
                self._output,
                self._write,
                self._link,
                self._folder,
                self._restore,
                self._pipe,
                self._plugin,
            )
        )
        change()

    def _variable(self) -> None:
        name = self.chance.choice(VARIABLES)
        values = ("/p:/q", "/q:/p", "/q", "/r:/p") if name == PATHS else ("", "1", "2")
        if self.chance.random() < 0.2:
            self.world.variables.pop(name, None)
        else:
            self.world.variables[name] = self.chance.choice(values)

    def _output(self) -> None:
        name = self.chance.choice(("artifact", "artifact", "other"))
        if self.chance.random() < 0.4:
            self.world.remove(f"{OUT}/{name}")
        else:
            self.world.write(f"{OUT}/{name}", self._text(), self.chance.random() < 0.5)

    def _write(self) -> None:
        self.world.write(self._place(), self._text(), self.chance.random() < 0.5)

    def _link(self) -> None:
        place = self._place()
        if place != "/r/robot":
            self.world.remove(place)
            self.world.make(place, "link", self.chance.choice(("a", "b", "/q/a", "/p", "../p/a", "nowhere")))

    def _folder(self) -> None:
        self.world.make(self._place(), FOLDER)

    def _pipe(self) -> None:
        if self.chance.random() < 0.2:
            self.world.make(self._place(), OTHER)

    def _install(self) -> None:
        for folder in ("/s", "/s/toy-1.dist-info"):
            self.world.make(folder, FOLDER)
        for name, text in plugin.FILES.items():
            self.world.write(f"/s/{name}", text.encode())

    def _plugin(self) -> None:
        name, text = plugin.changed(self.chance)
        self._install()
        if self.chance.random() < 0.3:
            self.world.remove(f"/s/{name.partition('/')[0]}")
        else:
            self.world.write(f"/s/{name}", text.encode(), self.chance.random() < 0.5)

    def _restore(self) -> None:
        """Come back to something that a program can do much with."""
        for folder in FOLDERS:
            self.world.make(folder, FOLDER)
        for name in self.chance.sample(NAMES, 2):
            self.world.remove(f"/r/{name}")
        self.world.write(self.first, b"include b\nmesh c\nfind a\nenv X\nlist a\nreal d\nplug rules\n")
        self.world.write("/r/b", b"mesh d\nlink d\nreal a\nglob d\nhead c\nsize d\n")
        self.world.write("/r/c", b"texture d\nsurface")
        self.world.write("/p/a/model", b"model")
        self._install()

    def _place(self) -> str:
        return f"{self.chance.choice(FOLDERS)}/{self.chance.choice(NAMES)}"

    def _text(self) -> bytes:
        words = (
            "include",
            "list",
            "find",
            "env",
            "link",
            "real",
            "size",
            "same",
            "glob",
            "head",
            "mesh",
            "texture",
            "plug",
        )
        lines = []
        for _ in range(self.chance.randint(1, 6)):
            word = self.chance.choice(words)
            what = self.chance.choice(("X", "Y")) if word == "env" else self.chance.choice((*NAMES, "a/b", "../p/a"))
            lines.append(f"{word} {what}")
        return "\n".join(lines).encode()


def _is_none(kind: str, told: str) -> bool:
    """Say whether a run was told that there is nothing."""
    return told.startswith("! ") or (not told and kind in ("kind", "variable"))


def mesh_results() -> Callable[[], None]:
    """Keep what the process remembers while a run that knows nothing is made; return what puts it back."""
    from .program import mesh

    known = mesh.__closure__ and next(c.cell_contents for c in mesh.__closure__ if isinstance(c.cell_contents, dict))
    before = dict(known or {})

    def put_back() -> None:
        if known is not None:
            known.clear()
            known.update(before)

    return put_back
