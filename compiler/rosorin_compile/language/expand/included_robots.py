"""A foreign robot (URDF, xacro, SDF, MJCF), included as it is: prefixed, attached, joined like any file.

It is read when the arguments of the description are known, so that an include may have expressions, loops and
conditions. What it holds is never evaluated: ``${...}`` in another one's file is that one's.

``Robots`` takes the entries of ``include`` one by one; ``joint_above`` makes the joint that attaches a robot, and
``check_include`` says what is wrong with an entry.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, Protocol

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import (
    NOTE,
    TRUSTED,
    WARNING,
    Diagnostic,
    Related,
    Span,
    Suggestion,
    error,
)
from rosorin_compile.source.files import shown
from rosorin_compile.source.project import MESH_FILE, resolved
from rosorin_compile.source.rule_registry import FILES, Rule
from rosorin_compile.source.tree import Instance, Map, Place
from rosorin_compile.source.wording import first_of

from ..expression.functions import FUNCTIONS, kind_of
from ..schema import backend_of, sections
from .files import Asked
from .forms import hides_letters
from .ledger import Failed
from .nearby import ADDRESS, address, corrected, outside, package_missing
from .parts import sourced
from .prefixing import from_one_folder, moved, prefixed, relative_files, with_files_named
from .scope import Scope

if TYPE_CHECKING:
    from .files import Reader

RULES = (
    Rule(
        "include-mesh-path",
        "An included robot names meshes as seen from its own file; the artifacts are elsewhere.",
        "`meshes: FOLDER`, as seen from the artifacts, or `meshes: package://NAME`.",
        FILES,
    ),
    Rule(
        "trust-ignored",
        "A warning: `trust` of an include has no effect, because trust comes from the person who runs the command.",
        "Remove the key. If you trust the authors of the files, use `--trust` or set `ROSORIN_COMPILE_TRUST=1`.",
        FILES,
    ),
    Rule(
        "include-renamed",
        "A note: in elements of an included robot that are kept as they are, names got its prefix.",
        topic=FILES,
    ),
    Rule(
        "include-settings",
        "A warning: an included robot has settings of its simulation (a free base, a time step, a solver, ...) that an "
        "output cannot take over, because the output or another include has others.",
        "Decide in the output: `mjcf: {option: {timestep: 0.001}}`, `base: free`.",
        FILES,
    ),
)


Tell = Callable[[Diagnostic], None]

_OF_ATTACHMENT = ("xyz", "rpy", "joint", "publisher")
# What the readers say to somebody at a command line, and what it is called here.
_WORDS = (
    (re.compile(r"--package (\S+)=PATH"), r"packages: {\1: FOLDER}"),
    (re.compile(r"give it one: (\S+):=VALUE"), r"give it one: args: {\1: VALUE}"),
    (re.compile(r"--lenient\b"), "lenient: true"),
)
_FEW = 4
_MJCF = "mjcf"
_DEFAULT = ("integrator", "Euler")  # which an MJCF has that says nothing


class How(NamedTuple):
    """How a foreign file is read."""

    lenient: bool


class ForeignReader(Protocol):
    """What reads robots in other formats; the pipeline has one."""

    def endings(self) -> tuple[str, ...]:
        """Return how the names of files end that a description may include and that are no descriptions."""

    def read(
        self, path: Path, texts: Mapping[str, str], packages: Mapping[str, Path], how: How, tell: Tell, by: Span
    ) -> Foreign:
        """Return the robot of a file; ``by`` is the place that names it."""


class Foreign(Protocol):
    """What comes of reading a foreign robot: its tree, None for a broken one, what is to say, and what was read.

    ``takes_arguments`` says that its file was told arguments.
    """

    @property
    def tree(self) -> Map | None: ...

    @property
    def diagnostics(self) -> list[Diagnostic]: ...

    @property
    def files(self) -> tuple[Path, ...]: ...

    @property
    def takes_arguments(self) -> bool: ...


class Robots:
    """Reads the foreign robots that a description includes; each file once, however often it is included."""

    def __init__(
        self,
        reader: Reader,
        robots: ForeignReader,
        scope: Scope,
        tell: Tell | None,
        packages: Mapping[str, Path],
    ) -> None:
        self.reader = reader
        self.robots = robots
        self.scope = scope
        self.tell = tell
        self.packages = packages
        self.known: dict[tuple[Any, ...], Map | None] = {}
        self.places: dict[tuple[Any, ...], Place] = {}
        self.read: list[tuple[Map, Map, Instance]] = []

    def fragments(self) -> Iterator[Map | None]:
        """Yield the sections that each include makes, in their order; None for one with mistakes, after telling."""
        for include in self.reader.robots:
            try:
                for scope, entry in self.scope.entries(include.item):
                    yield self._fragment(scope.resolve(entry, include.place), scope, include)
            except Failed:
                yield None

    def _fragment(self, entry: Map, scope: Scope, include: Asked) -> Map:
        """Return the sections of a robot, prefixed and attached. Raises Failed after reporting."""
        check_include(entry, scope)
        via = Instance("included here", include.place.span, scope.via or include.place.via)
        tree = self._read(entry, scope, include, via)
        self.read.append((entry, tree, via))
        scope.count(_size(tree), *include.place)
        prefix = entry.get("prefix") or ""
        made, changed = prefixed(tree, prefix, via)
        if changed:
            names = [f"{name} ({count})" if count > 1 else name for name, count in changed.items()]
            message = f'in elements that are kept as they are, "{prefix}" was put before {first_of(names, _FEW)}'
            self._say(Diagnostic("include-renamed", NOTE, message, entry.value_spans["prefix"]), via.parent)
        return self._attached(self._meshes(made, entry, via), entry, via, tree)

    def settle(self, tree: Map) -> None:
        """Give the MJCF outputs of a description the settings of the simulation of what it includes.

        What an output has itself is kept; of two includes the first decides. What is lost is reported.
        """
        outputs = tree.get("outputs")
        mine = [
            name for name, one in (outputs or {}).items() if isinstance(one, Map) and backend_of(name, one) == _MJCF
        ]
        for entry, robot, via in self.read if mine else ():
            settings = (robot.get("outputs") or {}).get(_MJCF) or {}
            lost: list[str] = []
            for name in mine:
                output = tree["outputs"][name].copied()
                for key, value in (settings.get("option") or {}).items():
                    options = output["option"].copied() if isinstance(output.get("option"), Map) else Map(output.span)
                    if (key, value) != _DEFAULT and options.get(key, value) != value:
                        lost.append(f"{key} {value}")
                    elif (key, value) != _DEFAULT:
                        options.put(key, value, entry.span, entry.span)
                        output.put("option", options, entry.span, entry.span)
                if settings.get("contacts") and len(self.read) == 1 and not self._moves_more(tree, robot):
                    output.setdefault_at("contacts", settings["contacts"], entry.span)
                if settings.get("base") == "free" and entry.get("parent") is None:
                    output.setdefault_at("base", "free", entry.span)
                    if output["base"] != "free":
                        lost.append("a free base")
                    elif "root" in robot and len(self.read) == 1:
                        tree.setdefault_at("root", robot["root"], entry.span)
                outputs = tree["outputs"].copied()
                outputs[name] = output
                tree["outputs"] = outputs
            if lost:
                message = (
                    f"settings of {Path(entry['file']).name} that the MJCF does not take over: {first_of(lost, _FEW)}"
                )
                help = "the output or another include has others: decide in the output"
                diagnostic = Diagnostic("include-settings", WARNING, message, entry.value_spans["file"], (), help)
                self._say(diagnostic, via.parent)

    @staticmethod
    def _moves_more(tree: Map, robot: Map) -> bool:
        """Return True if a description has more joints that move than a robot that it includes."""
        counts = [
            sum(isinstance(one, Map) and one.get("type") != "fixed" for one in (some.get("joints") or {}).values())
            for some in (tree, robot)
        ]
        return bool(counts[0] > counts[1])

    def _meshes(self, made: Map, entry: Map, via: Instance) -> Map:
        """Return a robot whose meshes are named as its artifacts find them; say where they do not."""
        files = relative_files(made)
        folder = entry.get("meshes")
        if folder is not None:
            if not files:
                message = (
                    f"{Path(entry['file']).name} names no mesh or texture by a relative path: nothing to put before"
                )
                span = entry.key_spans["meshes"]
                self._say(Diagnostic("ignored-key", WARNING, message, span, (), "remove meshes"), via.parent)
            return moved(made, folder)
        base = Path(os.path.abspath(made.span.source.path)).parent
        top, names = from_one_folder(base, {name: os.path.normpath(base / name) for name in files})
        names = {old: new for old, new in names.items() if self._is_there(base, top, new)}
        made = with_files_named(made, lambda name: names.get(name, name)) if names else made
        files = [name for name in files if name not in names]
        if files:
            seen = f"seen from {Path(entry['file']).name}, but readers look from the artifacts"
            message = f"files of meshes or textures are named as {seen}: {first_of(files, 1)}"
            help = "say what to put before: meshes: FOLDER, as seen from the artifacts, or package://NAME"
            span = entry.value_spans["file"]
            self._say(Diagnostic("include-mesh-path", WARNING, message, span, (), help), via.parent)
        return made

    def _is_there(self, base: Path, top: Path, name: str) -> bool:
        """Say whether a file is in a folder, and no other one is called so from a folder nearer to ``base``."""
        above = [folder for folder in (base, *base.parents) if folder.is_relative_to(top)]
        there = [folder for folder in above if files.is_file(folder / name)]
        for folder in above:
            here = folder / name if folder in there else None
            self.reader.resolved.append(resolved(MESH_FILE, str(folder / name), "", here))
        return there == [top]

    def _read(self, entry: Map, scope: Scope, include: Asked, via: Instance) -> Map:
        """Return the tree of a robot; what there is to say of its file is said once. Raises Failed."""
        own = {name: include.by.parent / folder for name, folder in (entry.get("packages") or {}).items()}
        packages = {**own, **self.packages}
        path = self._file(entry, scope, include, packages)
        texts = {name: self._text(entry["args"], name, scope) for name in entry.get("args") or ()}
        how = How(bool(entry.get("lenient")))
        if "trust" in entry:
            self._warn_of_trust(entry, scope)
        key = (str(path), tuple(texts.items()), tuple(packages.items()), how.lenient)
        self._check_prefix(path, entry, texts, scope, include.place)
        if key not in self.known:
            self.known[key] = self._opened(path, texts, packages, how, entry, scope, include, via)
        tree = self.known[key]
        if tree is None:
            raise Failed
        return tree

    def _opened(
        self,
        path: Path,
        texts: dict[str, str],
        packages: dict[str, Path],
        how: How,
        entry: Map,
        scope: Scope,
        include: Asked,
        via: Instance,
    ) -> Map | None:
        """Return the tree of a file that is read for the first time; None for one that is wrong, after telling."""

        def tell(diagnostic: Diagnostic) -> None:
            self._say(diagnostic, via, ahead=True)

        read = self.robots.read(path, texts, packages, how, tell, include.place.span)
        self.reader.files += [file for file in read.files if file not in self.reader.files]
        for diagnostic in read.diagnostics:
            self._say(corrected(diagnostic, entry["file"], path), via)
        if not texts or read.takes_arguments or read.tree is None:
            return read.tree
        place = Place(entry["args"].key_spans[next(iter(texts))], via.parent)
        message = f"{path.name} has no arguments: only a xacro has them"
        scope.report("unknown-argument", message, place, "remove args")
        return None

    def _check_prefix(self, path: Path, entry: Map, texts: dict[str, str], scope: Scope, place: Place) -> None:
        """Report a file that is included again under the same names. Raises Failed after that."""
        prefix = entry.get("prefix") or ""
        key = (path, prefix, *texts.items())
        if key in self.places:
            related = [Related("first included here", self.places[key].span)]
            how = f'with the prefix "{prefix}"' if prefix else "without a prefix"
            help = "give each its own prefix: left_, right_"
            message = f"{path.name} is included twice {how}: all of its names would stand twice"
            scope.report("duplicate-name", message, place, help, related)
            raise Failed
        self.places[key] = place

    def _file(self, entry: Map, scope: Scope, include: Asked, packages: dict[str, Path]) -> Path:
        """Return the file that an include names: in the project of the description, or in a ROS package."""
        package, name = address(entry["file"])
        package = package or entry.get("package")
        if package is None:
            target = include.by.parent / name
            if not self.reader.inside(target):
                help = f"move it inside, or name the ROS package that it is in: {ADDRESS}NAME/FILE"
                scope.report("include-outside", outside(name, include.by, self.reader.project), include.place, help)
                raise Failed
            return Path(shown(target))
        key = "package" if entry.get("package") else "file"
        folder = self.reader.package(package, packages, include.by)
        if folder is None:
            message, help = package_missing(package)
            scope.report("package-missing", message, place_of(entry, key, scope), help)
            raise Failed
        inner = Path(os.path.normpath(name))
        if inner.is_absolute() or inner.parts[:1] == (os.pardir,):
            message = f'{name} is outside the folder of the package "{package}"'
            scope.report("include-outside", message, place_of(entry, "file", scope), "name a file in the package")
            raise Failed
        return Path(shown(folder / inner))

    def _text(self, values: Map, name: str, scope: Scope) -> str:
        """Return an argument as a xacro takes it: text; a quantity in SI units."""
        value = values[name]
        if isinstance(value, bool):
            return str(value).lower()
        if isinstance(value, (str, int, float)):
            return str(FUNCTIONS["str"](value))
        message = f'the argument "{name}" of a xacro is text or a number, not {kind(value)}'
        scope.report("bad-argument", message, place_of(values, name, scope))
        raise Failed

    def _attached(self, made: Map, entry: Map, via: Instance, tree: Map) -> Map:
        """Return a robot with the joint that attaches its root, and a source for each of its entries."""
        parent = entry.get("parent")
        if parent is not None:
            root = root_of(made)
            joints = Map(made.span)
            name = str(entry.get("joint") or free_name(root, made))
            span = entry.value_spans["joint" if entry.get("joint") else "parent"]
            joints.put(name, joint_above(root, entry, via.parent), span, span)
            for other, joint in (made.get("joints") or {}).items():
                if other == name:
                    self._taken(name, via, made["joints"])
                joints.put(other, joint, made["joints"].key_spans[other], made["joints"].value_spans[other])
            made.put("joints", joints, made.span, made.span)
        ignored = [key for key in _OF_ATTACHMENT if entry.get(key) is not None and parent is None]
        if ignored:
            message = f'an include has "{ignored[0]}", but what it includes is attached to nothing'
            span = entry.key_spans[ignored[0]]
            self._say(Diagnostic("ignored-key", WARNING, message, span, (), "write parent: FRAME"), via.parent)
        owner = entry if entry.get("source") is not None else tree
        for section in (key for key, node in sections().items() if node.sourced):
            if isinstance(made.get(section), Map):
                made[section] = sourced(made[section], owner)
        return made

    def _taken(self, name: str, via: Instance, joints: Map) -> NoReturn:
        message = f'joint "{name}" is defined twice'
        clash = error("duplicate-name", message, joints.key_spans[name], "give the include another joint: NAME")
        self._say(clash, via)
        raise Failed

    def _warn_of_trust(self, entry: Map, scope: Scope) -> None:
        """Report that a description cannot grant trust."""
        message = "trust of an include has no effect: trust comes from the person who runs the command"
        span = place_of(entry, "trust", scope).span
        help = "remove it; --trust or ROSORIN_COMPILE_TRUST=1 silences the warning xacro-runs-code"
        self.reader.diagnostics.append(Diagnostic("trust-ignored", WARNING, message, span, (), help))

    def _say(self, diagnostic: Diagnostic, via: Instance | None, ahead: bool = False) -> None:
        """Say something of a foreign file, in the words of an include; ``ahead``: before anything is done."""
        message, help = diagnostic.message, diagnostic.help
        for there, here in _WORDS:
            message, help = there.sub(here, message), there.sub(here, help)
        stack = tuple(via.stack()) if via else ()
        # Where the file cannot be read, the diagnostic points at the include itself: that needs no note.
        stack = stack[1:] if stack and diagnostic.span == stack[0].span else stack
        told = replace(diagnostic, message=message, help=help, related=(*diagnostic.related, *stack))
        if ahead and self.tell is not None:
            self.tell(told)
        elif diagnostic.numbers != TRUSTED:
            self.reader.diagnostics.append(told)


def _size(node: Any) -> int:
    """Return how many values a piece of a tree holds, itself included."""
    items = node.values() if isinstance(node, Map) else node if isinstance(node, list) else ()
    return 1 + sum(map(_size, items))


def root_of(tree: Map) -> str:
    """Return the root link of a robot: what is read as one has a single root."""
    children = {joint["child"] for joint in (tree.get("joints") or {}).values()}
    return next(str(name) for name in tree["links"] if name not in children)


def free_name(root: str, tree: Map) -> str:
    """Return a name for the joint above a root that no joint of the robot has."""
    taken = tree.get("joints") or ()
    name = f"{root}_joint"
    while name in taken:
        name = name.removesuffix("_joint") + "_mount_joint"
    return name


def joint_above(root: str, entry: Map, via: Instance | None) -> Map:
    """Return the joint that attaches a root: what the include says of it, at its places."""
    span = entry.value_spans["parent"]
    made = Map(span, via)
    made.put("type", "fixed", span, span)
    made.put("child", root, span, span)
    for key in ("parent", "xyz", "rpy", "publisher"):
        if entry.get(key) is not None:
            made.put(key, entry[key], entry.key_spans[key], entry.value_spans[key])
    return made


_OF_FILE = ("file", "package", "packages", "args", "lenient", "trust")
KEYS = (*_OF_FILE, "prefix", "meshes", "parent", "xyz", "rpy", "joint", "publisher", "source", "for", "if")
_TEXTS = ("file", "package", "prefix", "meshes", "parent", "joint")
_PREFIX = re.compile(r"([^\s<>&\"']+( +[^\s<>&\"']+)* *)?")  # what a name can begin with


def check_include(entry: Map, scope: Scope) -> None:
    """Report keys and kinds of values that an include cannot have. Raises Failed after that."""
    wrong = 0
    for key in entry:
        if key not in KEYS:
            place = Place(entry.key_spans[key], scope.via or entry.via)
            scope.report("unknown-key", f'an include has no key "{key}"', place, Suggestion(key, KEYS))
            wrong += 1
    kinds: list[tuple[str, type, str]] = [(key, str, "text") for key in _TEXTS]
    kinds += [("args", Map, "a mapping"), ("packages", Map, "a mapping")]
    kinds += [(key, bool, "true or false") for key in ("lenient", "trust")]
    for key, wanted, word in kinds:
        value = entry.get(key)
        if not isinstance(value, wanted) and (value is not None or key == "file"):
            message = f"{key} of an include is {word}, not {kind(value)}"
            missing = f"an include needs {key}, the name of the robot's file"
            scope.report("wrong-type", message if key in entry else missing, place_of(entry, key, scope))
            wrong += 1
    prefix = entry.get("prefix")
    if isinstance(prefix, str) and not _PREFIX.fullmatch(prefix):
        help = "no markup, no quotes; spaces only within"
        scope.report("bad-name", f'no name can begin with "{prefix}"', place_of(entry, "prefix", scope), help)
        wrong += 1
    elif hides_letters("prefix", entry, scope):
        wrong += 1
    for name, folder in (entry.get("packages") or {}).items() if not wrong else ():
        if not isinstance(folder, str):
            place = place_of(entry["packages"], name, scope)
            scope.report("wrong-type", f"a package is a folder: text, not {kind(folder)}", place)
            wrong += 1
    if wrong:
        raise Failed


def place_of(entry: Map, key: str, scope: Scope) -> Place:
    """Return where the value of a key stands; of one that is missing, where the whole stands."""
    return Place(entry.value_spans.get(key, entry.span), scope.via or entry.via)


def kind(value: Any) -> str:
    """Return in words what kind of value this is."""
    if isinstance(value, (Map, list)):
        return "a mapping" if isinstance(value, Map) else "a list"
    return "empty" if value is None else kind_of(value)
