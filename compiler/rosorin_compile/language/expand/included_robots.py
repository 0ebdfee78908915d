"""Robots in other formats (URDF, xacro, SDF, MJCF) that a description includes: prefixed, attached, joined like a file.

They are read when the arguments of the description have values, so that an include may have expressions, loops and
conditions. What their files contain is never evaluated.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, TRUSTED, WARNING, Diagnostic, Related, error
from rosorin_compile.source.files import shown
from rosorin_compile.source.project import MESH_FILE, resolved
from rosorin_compile.source.rule_registry import FILES, Rule
from rosorin_compile.source.tree import Instance, Map, Place, Seq, Text
from rosorin_compile.source.wording import first_of
from rosorin_compile.source.xml.mujoco import with_files
from rosorin_compile.source.xml.references import Reference, renamed

from ..expression.functions import FUNCTIONS, kind_of
from ..schema import backend_of, sections
from ..symbols import THINGS, SymbolTable
from .declarations import hides_letters, place_of
from .expansion import Failed
from .files import ADDRESS, INCLUDE_KINDS, IncludeError, check_include, with_nearest_file
from .joining import copy, sourced
from .placing import Use, map_items, placed
from .scope import Scope, value_place

if TYPE_CHECKING:
    from rosorin_compile.formats.load_robot import RobotReader

    from .files import Reader, RobotInclude

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
_KINDS: dict[str, type] = {**INCLUDE_KINDS, "lenient": bool, "trust": bool}
_KINDS |= dict.fromkeys(("prefix", "meshes", "parent", "joint"), str)
_KEYS = ("xyz", "rpy", "publisher", "source", "for", "if")
_PREFIX = re.compile(r"([^\s<>&\"']+( +[^\s<>&\"']+)* *)?")  # what a name can begin with
# What the readers suggest to somebody at a command line, and what it is called in an include.
_WORDS = (
    (re.compile(r"--package (\S+)=PATH"), r"packages: {\1: FOLDER}"),
    (re.compile(r"give it one: (\S+):=VALUE"), r"give it one: args: {\1: VALUE}"),
    (re.compile(r"--lenient\b"), "lenient: true"),
)
_FEW = 4
_MJCF = "mjcf"
_DEFAULT = ("integrator", "Euler")  # of an MJCF without an option
# Elements of URDF whose name has to be unique, by the element around: they get the prefix whatever it is.
_UNIQUE = {
    ("robot", "ros2_control"),
    ("robot", "transmission"),
    ("transmission", "actuator"),
    ("ros2_control", "gpio"),
    ("ros2_control", "sensor"),
}
# Elements whose name is a word of another program, and parts of the names of attributes that name no link or joint.
_WORDS_OF_OTHERS = {"command_interface", "state_interface", "param", "plugin", "property"}
_NO_NAMES = ("topic", "service", "namespace", "remapping", "uri", "filename", "material")

# An address, an absolute path, or one with the letter of a drive.
_ABSOLUTE = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\\\")
OF_MJCF = "mjcf_elements"  # a list of elements of XML


class IncludedRobots:
    """Reads the robots that a description includes; each file once for each set of arguments."""

    def __init__(
        self, reader: Reader, robots: RobotReader, scope: Scope, tell: Tell | None, packages: Mapping[str, Path]
    ) -> None:
        self.reader = reader
        self.robots = robots
        self.scope = scope
        self.tell = tell
        self.packages = packages
        self.trees: dict[tuple[Any, ...], Map | None] = {}
        self.places: dict[tuple[Any, ...], Place] = {}
        self.included: list[tuple[Map, Map, Instance]] = []

    def fragments(self) -> Iterator[Map | None]:
        """Yield the sections of each included robot, in order; None for one with errors, after reporting."""
        for include in self.reader.robots:
            try:
                for scope, entry in self.scope.entries(include.item):
                    yield self._fragment(scope.resolve(entry, include.place), scope, include)
            except Failed:
                yield None

    def _fragment(self, entry: Map, scope: Scope, include: RobotInclude) -> Map:
        """Return the sections of a robot, prefixed and attached. Raises Failed after reporting."""
        _check_include(entry, scope)
        via = Instance("included here", include.place.span, scope.via or include.place.via)
        tree = self._tree(entry, scope, include, via)
        self.included.append((entry, tree, via))
        scope.count(_size(tree), *include.place)
        prefix = entry.get("prefix") or ""
        made, changed = prefixed(tree, prefix, via)
        if changed:
            names = [f"{name} ({count})" if count > 1 else name for name, count in changed.items()]
            message = f'in elements that are kept as they are, "{prefix}" was put before {first_of(names, _FEW)}'
            self._report(Diagnostic("include-renamed", NOTE, message, entry.value_spans["prefix"]), via.parent)
        return self._attached(self._with_meshes(made, entry, via), entry, via, tree)

    # Reading

    def _tree(self, entry: Map, scope: Scope, include: RobotInclude, via: Instance) -> Map:
        """Return the tree of a robot; its file is read once. Raises Failed after reporting."""
        packages = self.reader.packages_of(entry, include.by)
        package = entry.get("package")
        try:
            path = Path(shown(self.reader.target(entry["file"], package, include.by, packages)))
        except IncludeError as problem:
            key = "package" if package and problem.rule == "package-missing" else "file"
            is_package = package or entry["file"].startswith(ADDRESS)
            place = place_of(entry, key, scope) if is_package else include.place
            raise scope.failed(problem.rule, problem.message, place, problem.help) from None
        texts = {name: _argument(entry["args"], name, scope) for name in entry.get("args") or ()}
        if "trust" in entry:
            message = "trust of an include has no effect: trust comes from the person who runs the command"
            help = "remove it; --trust or ROSORIN_COMPILE_TRUST=1 silences the warning xacro-runs-code"
            span = place_of(entry, "trust", scope).span
            self.reader.diagnostics.append(Diagnostic("trust-ignored", WARNING, message, span, (), help))
        prefix = entry.get("prefix") or ""
        names = (path, prefix, *texts.items())
        if names in self.places:
            related = [Related("first included here", self.places[names].span)]
            how = f'with the prefix "{prefix}"' if prefix else "without a prefix"
            message = f"{path.name} is included twice {how}: all of its names would stand twice"
            help = "give each its own prefix: left_, right_"
            raise scope.failed("duplicate-name", message, include.place, help, related)
        self.places[names] = include.place
        lenient = bool(entry.get("lenient"))
        same = (str(path), tuple(texts.items()), tuple(packages.items()), lenient)
        if same not in self.trees:
            self.trees[same] = self._read(path, texts, packages, lenient, entry, scope, via)
        tree = self.trees[same]
        if tree is None:
            raise Failed
        return tree

    def _read(
        self,
        path: Path,
        texts: dict[str, str],
        packages: dict[str, Path],
        lenient: bool,
        entry: Map,
        scope: Scope,
        via: Instance,
    ) -> Map | None:
        """Return the tree of a file; None after reporting its errors."""

        def tell(diagnostic: Diagnostic) -> None:
            self._report(diagnostic, via, ahead=True)

        foreign = self.robots.read(path, texts, packages, lenient, tell, via.span)
        self.reader.files += [file for file in foreign.files if file not in self.reader.files]
        for diagnostic in foreign.diagnostics:
            self._report(with_nearest_file(diagnostic, entry["file"], path), via)
        if texts and not foreign.takes_arguments and foreign.tree is not None:
            place = Place(entry["args"].key_spans[next(iter(texts))], via.parent)
            scope.report(
                "unknown-argument", f"{path.name} has no arguments: only a xacro has them", place, "remove args"
            )
            return None
        return foreign.tree

    def _report(self, diagnostic: Diagnostic, via: Instance | None, ahead: bool = False) -> None:
        """Report something about an included file, in the words of an include; ``ahead``: before it is read."""
        message, help = diagnostic.message, diagnostic.help
        for pattern, replacement in _WORDS:
            message, help = pattern.sub(replacement, message), pattern.sub(replacement, help)
        stack = tuple(via.stack()) if via else ()
        # If the file cannot be read, the diagnostic is already at the include itself.
        stack = stack[1:] if stack and diagnostic.span == stack[0].span else stack
        reported = replace(diagnostic, message=message, help=help, related=(*diagnostic.related, *stack))
        if ahead and self.tell is not None:
            self.tell(reported)
        elif diagnostic.numbers != TRUSTED:
            self.reader.diagnostics.append(reported)

    # Meshes

    def _with_meshes(self, made: Map, entry: Map, via: Instance) -> Map:
        """Return a robot with the mesh files named as its artifacts find them; warn where they do not."""
        names = relative_files(made)
        file, folder = Path(entry["file"]).name, entry.get("meshes")
        if folder is not None:
            if not names:
                message = f"{file} names no mesh or texture by a relative path: nothing to put before"
                span = entry.key_spans["meshes"]
                self._report(Diagnostic("ignored-key", WARNING, message, span, (), "remove meshes"), via.parent)
            return move_files(made, folder)
        base = Path(os.path.abspath(made.span.source.path)).parent
        places = {name: os.path.normpath(base / name) for name in names}
        # The nearest folder, that of the robot or one above it, that contains all of them: artifacts find them there.
        top = Path(os.path.commonpath([base, *places.values()]))
        new = {name: Path(os.path.relpath(path, top)).as_posix() for name, path in places.items()}
        new = {name: file for name, file in new.items() if self._is_only_in(top, base, file)}
        made = map_files(made, lambda name: new.get(name, name)) if new else made
        names = [name for name in names if name not in new]
        if names:
            seen = f"seen from {file}, but readers look from the artifacts"
            message = f"files of meshes or textures are named as {seen}: {first_of(names, 1)}"
            help = "say what to put before: meshes: FOLDER, as seen from the artifacts, or package://NAME"
            span = entry.value_spans["file"]
            self._report(Diagnostic("include-mesh-path", WARNING, message, span, (), help), via.parent)
        return made

    def _is_only_in(self, top: Path, base: Path, name: str) -> bool:
        """Return True if a file is in a folder, and no other file of that name in a folder nearer to ``base``."""
        above = [folder for folder in (base, *base.parents) if folder.is_relative_to(top)]
        existing = [folder for folder in above if files.is_file(folder / name)]
        for folder in above:
            path = folder / name if folder in existing else None
            self.reader.resolved.append(resolved(MESH_FILE, str(folder / name), "", path))
        return existing == [top]

    # Attaching

    def _attached(self, made: Map, entry: Map, via: Instance, tree: Map) -> Map:
        """Return a robot with the joint that attaches its root, and a source for each of its entries."""
        parent = entry.get("parent")
        if parent is not None:
            root = _root_of(made)
            have = made.get("joints") or Map(made.span)
            name = str(entry.get("joint") or _free_name(root, have))
            span = entry.value_spans["joint" if entry.get("joint") else "parent"]
            if name in have:
                message = f'joint "{name}" is defined twice'
                help = "give the include another joint: NAME"
                self._report(error("duplicate-name", message, have.key_spans[name], help), via)
                raise Failed
            joints = Map(made.span)
            joints.put(name, _joint_above(root, entry, via.parent), span, span)
            for other, joint in have.items():
                joints.put(other, joint, have.key_spans[other], have.value_spans[other])
            made.put("joints", joints, made.span, made.span)
        ignored = [key for key in _OF_ATTACHMENT if entry.get(key) is not None and parent is None]
        if ignored:
            message = f'an include has "{ignored[0]}", but what it includes is attached to nothing'
            span = entry.key_spans[ignored[0]]
            self._report(Diagnostic("ignored-key", WARNING, message, span, (), "write parent: FRAME"), via.parent)
        owner = entry if entry.get("source") is not None else tree
        for section in (key for key, node in sections().items() if node.sourced):
            if isinstance(made.get(section), Map):
                made[section] = sourced(made[section], owner)
        return made

    # Settings of the simulation

    def settle(self, tree: Map) -> None:
        """Give the MJCF outputs of a description the settings of the simulation of the included robots.

        What an output defines itself is kept; of two includes the first decides. What is lost is reported.
        """
        outputs = tree.get("outputs")
        names = [
            name
            for name, output in (outputs or {}).items()
            if isinstance(output, Map) and backend_of(name, output) == _MJCF
        ]
        for entry, robot, via in self.included if names else ():
            settings = (robot.get("outputs") or {}).get(_MJCF) or {}
            is_only = len(self.included) == 1
            lost: list[str] = []
            tree["outputs"] = outputs = copy(tree["outputs"])
            for name in names:
                output = outputs[name] = copy(outputs[name])
                for key, value in (settings.get("option") or {}).items():
                    options = copy(output["option"]) if isinstance(output.get("option"), Map) else Map(output.span)
                    if (key, value) == _DEFAULT:
                        continue
                    if options.get(key, value) != value:
                        lost.append(f"{key} {value}")
                        continue
                    options.put(key, value, entry.span, entry.span)
                    output.put("option", options, entry.span, entry.span)
                if settings.get("contacts") and is_only and _moving_joints(tree) <= _moving_joints(robot):
                    output.setdefault_at("contacts", settings["contacts"], entry.span)
                if settings.get("base") == "free" and entry.get("parent") is None:
                    output.setdefault_at("base", "free", entry.span)
                    if output["base"] != "free":
                        lost.append("a free base")
                    elif "root" in robot and is_only:
                        tree.setdefault_at("root", robot["root"], entry.span)
            if lost:
                file = Path(entry["file"]).name
                message = f"settings of {file} that the MJCF does not take over: {first_of(lost, _FEW)}"
                help = "the output or another include has others: decide in the output"
                span = entry.value_spans["file"]
                self._report(Diagnostic("include-settings", WARNING, message, span, (), help), via.parent)


def _check_include(entry: Map, scope: Scope) -> None:
    """Report keys and values that an include of a robot cannot have. Raises Failed after that."""
    good = check_include(entry, scope, _KINDS, _KEYS)
    prefix = entry.get("prefix")
    if isinstance(prefix, str) and not _PREFIX.fullmatch(prefix):
        help = "no markup, no quotes; spaces only within"
        raise scope.failed("bad-name", f'no name can begin with "{prefix}"', place_of(entry, "prefix", scope), help)
    good &= not hides_letters("prefix", entry, scope)
    if not good:
        raise Failed


def _argument(values: Map, name: str, scope: Scope) -> str:
    """Return an argument as a xacro takes it: text; a quantity in SI units."""
    value = values[name]
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (str, int, float)):
        return str(FUNCTIONS["str"](value))
    kind = "empty" if value is None else kind_of(value)
    message = f'the argument "{name}" of a xacro is text or a number, not {kind}'
    raise scope.failed("bad-argument", message, Place(value_place(values, name).span, scope.via or values.via))


def prefixed(tree: Map, prefix: str, via: Instance) -> tuple[Map, Counter[str]]:
    """Return the sections of an imported robot with ``prefix`` before its names; ``via`` tells how it came here.

    Also return the names that were changed in elements for the URDF, each with how often.
    """
    fragment = Map(tree.span, via)
    for key, value in tree.items():
        if key not in sections() or not sections()[key].whole:
            fragment.put(key, value, tree.key_spans[key], tree.value_spans[key])
    names = SymbolTable(fragment).names()
    things, materials = names.among(THINGS), fragment.get("materials") or ()
    changed: Counter[str] = Counter()

    def with_prefix(name: str) -> str:
        changed[name] += 1
        return prefix + name

    def references(tags: tuple[str, ...], attributes: Mapping[str, str], text: str) -> Iterator[Reference]:
        tag, above = tags[-1], tags[-2] if len(tags) > 1 else "robot"
        for attribute, value in attributes.items():
            is_name = value in things and not (attribute == "name" and tag in _WORDS_OF_OTHERS)
            if attribute == "name" and tag == "material":
                is_name = value in materials
            is_name |= attribute == "name" and (above, tag) in _UNIQUE
            if value and is_name and not _is_no_name(attribute):
                yield Reference(value, "", attribute, "")
        if text in things and not _is_no_name(tag):
            yield Reference(text, "", "", "")

    def elements(text: str) -> str:
        return Text(renamed(text, with_prefix, references)) if prefix else text

    made = placed(fragment, Use(prefix), names, elements)
    if prefix and isinstance(made.get("materials"), Map):
        renamed_materials = Map(made["materials"].span, made["materials"].via)
        for name, entry in made["materials"].items():
            spans = made["materials"].key_spans[name], made["materials"].value_spans[name]
            renamed_materials.put(prefix + name, entry, *spans)
        made["materials"] = renamed_materials
    if prefix and isinstance(made.get("accept"), Seq):
        made["accept"] = _accepted(made["accept"], lambda name: prefix + name if name in things else name)
    return made, changed


def _is_no_name(word: str) -> bool:
    """Return True for an element or attribute that never contains the name of a link or joint."""
    return any(part in word.lower() for part in _NO_NAMES)


def _accepted(entries: Seq, rename: Callable[[str], str]) -> Seq:
    """Return the entries of ``accept`` with new names; a frame with a prefix is no longer one of the world."""
    made = Seq(entries.span, entries.via)
    for entry, span in zip(entries, entries.value_spans, strict=True):
        if entry["rule"] != "owns-world-frame":
            names = {"of": map_items(entry["of"], rename)} if "of" in entry else {}
            made.put(entry.like(names), span)
    return made


def _size(node: Any) -> int:
    """Return the number of values in a piece of a tree."""
    items = node.values() if isinstance(node, Map) else node if isinstance(node, list) else ()
    return 1 + sum(map(_size, items))


def _moving_joints(tree: Map) -> int:
    joints = (tree.get("joints") or {}).values()
    return sum(isinstance(joint, Map) and joint.get("type") != "fixed" for joint in joints)


def _root_of(tree: Map) -> str:
    """Return the root link of a robot, which has one."""
    children = {joint["child"] for joint in (tree.get("joints") or {}).values()}
    return next(str(name) for name in tree["links"] if name not in children)


def _free_name(root: str, joints: Map) -> str:
    """Return a name for the joint above a root that no joint of the robot has."""
    name = f"{root}_joint"
    while name in joints:
        name = name.removesuffix("_joint") + "_mount_joint"
    return name


def _joint_above(root: str, entry: Map, via: Instance | None) -> Map:
    """Return the joint that attaches a root, with the places of the include."""
    span = entry.value_spans["parent"]
    made = Map(span, via)
    made.put("type", "fixed", span, span)
    made.put("child", root, span, span)
    for key in ("parent", "xyz", "rpy", "publisher"):
        if entry.get(key) is not None:
            made.put(key, entry[key], entry.key_spans[key], entry.value_spans[key])
    return made


def map_files(tree: Map, rename: Callable[[str], str]) -> Map:
    """Return the tree of a robot in which each name of a mesh or texture file is what ``rename`` makes of it."""
    made = tree.copied()
    for key, value in tree.items():
        if key != "outputs":  # those are files too, of another kind
            made[key] = _mapped(value, rename, key)
    return made


def relative_files(tree: Map) -> list[str]:
    """Return the relative names of mesh and texture files in the tree of a robot, each once."""
    names: dict[str, str] = {}
    map_files(tree, lambda name: names.setdefault(name, name))
    return [name for name in names if not _ABSOLUTE.match(name)]


def move_files(tree: Map, folder: str) -> Map:
    """Return the tree of a robot with ``folder`` before the relative names of mesh and texture files."""
    before = f"{folder.rstrip('/')}/"
    return map_files(tree, lambda name: name if _ABSOLUTE.match(name) else before + name)


def _mapped(node: Any, rename: Callable[[str], str], key: str) -> Any:
    if isinstance(node, Map):
        made = node.copied()
        for name, value in node.items():
            # In a section mjcf, they are names of textures.
            is_file = key != "mjcf" and name in ("file", "texture") and isinstance(value, str)
            made[name] = rename(value) if is_file else _mapped(value, rename, name)
        return made
    if isinstance(node, Seq):
        return map_items(node, lambda item: _mapped(item, rename, key))
    return with_files(node, rename) if key == OF_MJCF and isinstance(node, str) else node
