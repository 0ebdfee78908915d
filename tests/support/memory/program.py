"""A small program over the functions of the door, whose asking depends on what it reads.

Each line of a file says what is asked; what comes of all lines is what is said, and what is written.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rosorin_compile import plugins, world

PATHS = "PATHS"


@world.asked_again
def mesh(path: str) -> str:
    """Return a mesh, and the texture that its first line names."""
    first, _, rest = world.text(path, errors="replace").partition("\n")
    if first.startswith("texture "):
        try:
            return f"{rest} with {world.read(Path(path).parent / first.split()[1])!r}"
        except OSError:
            return f"{rest} without a texture"
    return f"{first} {rest}"


def _called(made: Any) -> str:
    try:
        return str(made())
    except Exception as problem:
        return type(problem).__name__


class Program:
    """One run: ``said`` are its words, ``made`` the text of its artifact, ``failed`` says that there is none."""

    def __init__(self) -> None:
        self.said: list[str] = []
        self.made: list[str] = []
        self.failed = False

    def run(self, first: str) -> None:
        self._file(Path(first), ())

    def _file(self, path: Path, within: tuple[Path, ...]) -> None:
        real = world.real(path)
        if real in within or len(within) > 4:
            self.made.append("round")
            return
        try:
            lines = world.text(path, errors="replace").splitlines()
        except OSError as problem:
            self.said.append(f"cannot read {path}: {type(problem).__name__}")
            self.failed = True
            return
        for line in lines[:8]:
            word, _, rest = line.partition(" ")
            asked = getattr(self, f"_{word}", None)
            if asked is None or not rest:
                self.made.append(line)
            elif word == "include":
                self._file(path.parent / rest, (*within, real))
            else:
                self.made.append(f"{line}: {asked(path.parent, rest)}")

    def _include(self, folder: Path, rest: str) -> str:
        raise NotImplementedError

    def _list(self, folder: Path, rest: str) -> str:
        try:
            return str(world.names(folder / rest))
        except OSError as problem:
            return type(problem).__name__

    def _find(self, _: Path, rest: str) -> str:
        for entry in world.environment().get(PATHS, "").split(":"):
            if entry and world.kind(Path(entry, rest)) == world.FOLDER:
                try:
                    return f"{entry} {world.read(Path(entry, rest, 'model'))!r}"
                except OSError:
                    return f"{entry} has no model"
        return "nowhere"

    def _env(self, _: Path, rest: str) -> str:
        return f"{world.is_set(rest)} {world.variable(rest, 'unset')}"

    def _link(self, folder: Path, rest: str) -> str:
        return world.link(folder / rest)

    def _real(self, folder: Path, rest: str) -> str:
        return str(world.real(folder / rest))

    def _size(self, folder: Path, rest: str) -> str:
        try:
            return str(world.size(folder / rest)) if world.kind(folder / rest) == world.FILE else "no file"
        except OSError:
            return "gone"

    def _same(self, folder: Path, rest: str) -> str:
        return str(world.is_same(folder / rest, folder / "a"))

    def _glob(self, folder: Path, rest: str) -> str:
        return str([str(path) for path in world.matching(folder, f"*/{rest}")])

    def _head(self, folder: Path, rest: str) -> str:
        try:
            return repr(world.head(folder / rest, 3))
        except OSError as problem:
            return type(problem).__name__

    def _plug(self, _: Path, rest: str) -> str:
        loaded, problems = plugins.load(rest, object, lambda _: (), lambda _: False)
        return str([*(_called(made) for _, made in loaded), *map(str, problems)])

    def _mesh(self, folder: Path, rest: str) -> str:
        try:
            return mesh(str(folder / rest))
        except OSError as problem:
            return type(problem).__name__
