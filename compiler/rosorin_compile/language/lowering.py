"""The conversion of one tree: links, joints and edges so far, where each is defined, and problems."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Any, TypeVar

from rosorin_compile.model import Edge, Inertial, Joint, Link, Publisher
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, error
from rosorin_compile.source.files import is_file
from rosorin_compile.source.packages import Packages
from rosorin_compile.source.rule_registry import Rule
from rosorin_compile.source.tree import Map, Path

from .expand.provenance import problem_at
from .expand.scope import Scope
from .suppressions import is_accepted, names_at

T = TypeVar("T")


class LoweringError(Exception):
    """A value that cannot be converted; ``path`` is that of the mistake in the tree."""

    def __init__(self, rule: str, message: str, path: Path = (), help: Help = "") -> None:
        super().__init__(message)
        self.rule, self.message, self.path, self.help = rule, message, path, help


class Lowering:
    """The state of a conversion. Called, it reports a problem."""

    def __init__(self, tree: Map, scope: Scope | None, acceptable: dict[str, Rule]) -> None:
        self.tree, self.scope, self.acceptable = tree, scope, acceptable
        self.places: dict[tuple[str, str], Path] = {}
        self.frames: dict[str, tuple[str, Path]] = {}  # of each joint: its child, and where that is written
        self.diagnostics: list[Diagnostic] = []
        self.nodes: dict[str, Publisher] = {}
        self.edges: list[Edge] = []
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.urdf_elements: list[str] = []
        self.servos: tuple[ServoGroup, ...] = ()
        self.solids: dict[object, Inertial] = {}  # of mesh files by file and scale
        self._shared: dict[Hashable, Any] = {}

    def __call__(
        self, rule: str, message: str, path: Path, help: Help = "", related: tuple[Related, ...] = (), key: bool = False
    ) -> None:
        """Report a problem at a path of the tree, or at the last key of the path."""
        diagnostic = problem_at(self.scope, self.tree, path, rule, message, help, related, key)
        self.diagnostics.append(replace(diagnostic, of=names_at(self.tree, path)))

    def share(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return what ``make`` returns; the same object for the same key, unless problems were reported."""
        if key in self._shared:
            known: T = self._shared[key]
            return known
        before, made = len(self.diagnostics), make()
        if len(self.diagnostics) == before:
            self._shared[key] = made
        return made

    @contextmanager
    def reporting(self, where: str = "") -> Iterator[None]:
        """Report a LoweringError; ``where`` is appended to its message."""
        try:
            yield
        except LoweringError as problem:
            self(problem.rule, problem.message + where, problem.path, problem.help)

    def accepts(self, problem: LoweringError) -> bool:
        """Return True, and report the problem, if the description accepts it."""
        diagnostic = replace(error(problem.rule, "", None), of=names_at(self.tree, problem.path))
        if not is_accepted(self.tree, diagnostic, self.acceptable):
            return False
        self(problem.rule, problem.message, problem.path, problem.help)
        return True

    def place(self, kind: str, name: str, path: Path) -> None:
        """Record where a name is defined; report a second definition."""
        first = self.places.get((kind, name))
        if first is None:
            self.places[kind, name] = path
        else:
            related = (Related("first defined here", self.tree.locate(first, key=True).span),)
            self("duplicate-name", f'the {kind} "{name}" is defined twice', path, "rename one", related)

    def place_joint(self, name: str, path: Path, frame: str, frame_path: Path) -> None:
        """Record where a joint and its child frame are defined; report a frame that has a joint already."""
        child, first = self.frames.setdefault(name, (frame, frame_path))
        if child != frame or first == frame_path:
            self.place("joint", name, path)
            return
        related = (Related("first said here", self.tree.locate(first).span),)
        message = f'frame "{frame}" is defined twice: by {owner_of_frame(first)} and by {owner_of_frame(frame_path)}'
        help = "give each a frame of its own"
        if first[0] == "joints":
            help = f'a sensor brings the joint to its frame along: remove joint "{name}", or name another frame'
        self("duplicate-name", message, frame_path, help, related)

    def mesh_file(self, name: str, path: Path) -> FilePath | None:
        """Return the file of a mesh of a link: relative to the file of the link, or in a package."""
        here, first = (FilePath(span.source.path) for span in (self.tree.locate(path).span, self.tree.span))
        folders = [here.parent, first.parent]
        source = self.tree.get("source")
        if isinstance(source, Map) and isinstance(source.get("folder"), str):
            folders.append(first.parent / source["folder"])
        packages = Packages({}, os.environ, here)
        found = (packages.resolve(name, folder) for folder in folders)
        return next((file for file in found if file is not None and is_file(file)), None)


def owner_of_frame(path: Path) -> str:
    """Return in words what defines a frame, given the path of its name: a joint, or (an optical frame of) a sensor."""
    what = "joint" if path[0] == "joints" else "sensor"
    return f'{"the optical frame of " if "optical" in path[2:] else ""}{what} "{path[1]}"'
