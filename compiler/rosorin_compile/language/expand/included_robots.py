"""Read, rename and attach the robots in other formats (URDF, xacro, SDF, MJCF) that a description includes.

They are read after the arguments of the description have values; expressions in their files are not evaluated.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, TRUSTED, WARNING, Diagnostic, Related, SourceError, Span, error
from rosorin_compile.source.files import label
from rosorin_compile.source.tree import Instance, Map, Place, Seq, Text
from rosorin_compile.source.wording import first_of, phrase

from ..element_names import Reference, rename_references, with_files
from ..expression.functions import FUNCTIONS, KindError, kind_of
from ..expression.syntax import weight
from ..schema import backend_of, sections
from ..symbols import THINGS, SymbolTable
from .declarations import hides_letters, place_of
from .files import ADDRESS, INCLUDE_KINDS, check_include, with_nearest_file
from .placing import Use, copy, map_items, map_table, place_fragment, with_sources
from .scope import EvaluationFailed, Scope

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import RobotReader
    from rosorin_compile.formats.imported_robot import ImportedRobot

    from .files import Reader


Tell = Callable[[Diagnostic], None]

_KINDS: dict[str, type] = {**INCLUDE_KINDS, "lenient": bool, "trust": bool, "with": Map}
_KINDS |= dict.fromkeys(("macro", "prefix", "meshes", "parent", "joint"), str)
_KEYS = ("xyz", "rpy", "publisher", "source", "for", "if")
_PREFIX = r"([^\s<>&\"']+( +[^\s<>&\"']+)* *)?"  # valid prefixes of names
# Patterns of command line options in help texts of importers, and keys of ``include`` to suggest instead.
_WORDS = (
    (re.compile(r"--package (\S+)=PATH"), r"packages: {\1: FOLDER}"),
    (re.compile(r"give it one: (\S+):=VALUE"), r"give it one: args: {\1: VALUE}"),
    (re.compile(r"--lenient\b"), "lenient: true"),
)
_FEW = 4
_MJCF = "mjcf"
_DEFAULT = ("integrator", "Euler")  # MuJoCo's default integrator
# URDF elements, as (parent, element), whose names must be unique: they always get the prefix.
_UNIQUE = {("robot", "ros2_control"), ("robot", "transmission"), ("transmission", "actuator")}
_UNIQUE |= {("ros2_control", "gpio"), ("ros2_control", "sensor")}
# Tags of elements whose name must not get the prefix, and attributes that never contain a link or joint name.
_WORDS_OF_OTHERS = {"command_interface", "state_interface", "param", "plugin", "property"}
_NO_NAMES = re.compile("topic|service|namespace|remapping|uri|filename|material", re.IGNORECASE)

# A URL, an absolute path, or a path with a Windows drive letter.
_ABSOLUTE = r"[A-Za-z][A-Za-z0-9+.-]*:|/|\\\\"
OF_MJCF = ("mjcf", "mjcf_elements")  # keys of the description and of a link with lists of MJCF elements


class IncludedRobot(NamedTuple):
    """The evaluated ``include`` entry of a robot; ``by`` is the including file, ``via`` the include in messages."""

    entry: Map
    scope: Scope
    place: Place
    by: Path
    via: Instance


class IncludedRobots:
    """Read the robots that a description includes; read a file only once for the same arguments."""

    def __init__(self, reader: Reader, robots: RobotReader, tell: Tell | None) -> None:
        self.reader, self.robots, self.tell = reader, robots, tell
        self.read: dict[tuple[Any, ...], ImportedRobot | None] = {}
        self.places: dict[tuple[Any, ...], Place] = {}
        self.included: list[tuple[IncludedRobot, Map]] = []
        self.diagnostics: list[Diagnostic] = []
        self.told: set[str] = set()

    def fragments(self) -> Iterator[Map | None]:
        """Yield the sections of each included robot, or None for a robot with errors, which are reported."""
        for item, place, by in self.reader.robots:
            try:
                for scope, body in self.reader.scope.entries(item):
                    entry = scope.resolve(body, place)
                    _check_include(entry, scope)
                    via = Instance("included here", place.span, scope.via or place.via)
                    yield self._fragment(IncludedRobot(entry, scope, place, by, via))
            except EvaluationFailed:
                yield None

    def _fragment(self, include: IncludedRobot) -> Map:
        entry, foreign = include.entry, self._robot(include)
        tree = foreign.whole
        self.included.append((include, tree))
        include.scope.count(weight(tree), *include.place)
        prefix = entry.get("prefix") or ""
        made, changed = with_prefix(tree, prefix, include.via)
        if changed:
            names = [f"{name} ({count})" if count > 1 else name for name, count in changed.items()]
            message = f'the prefix "{prefix}" was added to names in copied XML: {first_of(names, _FEW)}'
            self._report(Diagnostic("include-renamed", NOTE, message, entry.value_spans["prefix"]), include.via.parent)
        made = self._attached(self._with_meshes(made, include), foreign, include)
        for section, node in sections().items():
            if node.sourced and isinstance(made.get(section), Map):
                made[section] = with_sources(made[section], entry if entry.get("source") is not None else tree)
        return made

    def _robot(self, include: IncludedRobot) -> ImportedRobot:
        entry, scope, place, by, _ = include
        packages, package = self.reader.packages_of(entry, by), entry.get("package")
        try:
            path = Path(label(self.reader.target(entry["file"], package, by, packages)))
        except SourceError as problem:
            found = problem.diagnostic
            key = "package" if package and found.rule == "package-missing" else "file"
            place = place_of(entry, key, scope) if package or entry["file"].startswith(ADDRESS) else place
            raise scope.fail(found.rule, found.message, place, found.help) from None
        texts: dict[str, str] = {}
        for name, value in (entry.get("args") or {}).items():
            try:
                texts[name] = FUNCTIONS["str"](value)
            except KindError:
                message = f'the argument "{name}" of a xacro file must be text or a number, not {kind_of(value)}'
                raise scope.fail("bad-argument", message, place_of(entry["args"], name, scope)) from None
        if "trust" in entry:
            message = '"trust" of an include has no effect: only the person who runs the command can trust a file'
            help = "remove it; --trust or ROSORIN_COMPILE_TRUST=1 silences the warning xacro-runs-code"
            self.diagnostics.append(Diagnostic("trust-ignored", WARNING, message, entry.value_spans["trust"], (), help))
        prefix = entry.get("prefix") or ""
        call = str([entry.get(key) for key in ("macro", "with", "parent", "xyz", "rpy")]) if "macro" in entry else ""
        names = (path, prefix, call, *texts.items())
        first = self.places.get(names)
        self.places[names] = place
        if first is not None:
            how = f'with the prefix "{prefix}"' if prefix else "without a prefix"
            message = f"{path.name} is included twice {how}, so all its names would be defined twice"
            related = [Related("first included here", first.span)]
            raise scope.fail("duplicate-name", message, place, 'give each entry its own "prefix"', related)
        same = (str(path), call, tuple(texts.items()), tuple(packages.items()), bool(entry.get("lenient")))
        if same not in self.read:
            self.read[same] = self._read(path, texts, packages, include)
        foreign = self.read[same]
        if foreign is None:
            raise EvaluationFailed
        return foreign

    def _read(
        self, path: Path, texts: dict[str, str], packages: dict[str, Path], include: IncludedRobot
    ) -> ImportedRobot | None:
        entry, scope, _, _, via = include
        tell = partial(self._report, via=via, ahead=True)
        foreign = self.robots.read(path, texts, packages, entry, tell, via.span)
        self.reader.files += [file for file in foreign.files if file not in self.reader.files]
        for diagnostic in foreign.diagnostics:
            is_here = diagnostic.span is not None and diagnostic.span.source is entry.span.source
            self._report(with_nearest_file(diagnostic, entry["file"], path), via.parent if is_here else via)
        if foreign.tree is None or foreign.takes_arguments:
            return None if foreign.tree is None else foreign
        if "macro" in entry:
            message = f"{path.name} defines no macros: only xacro files do"
            help = 'remove "macro" to include the file as a robot'
            scope.report("unknown-macro", message, place_of(entry, "macro", scope), help)
        elif texts:
            place = Place(entry["args"].key_spans[next(iter(texts))], via.parent)
            message = f"{path.name} takes no arguments: only xacro files do"
            scope.report("unknown-argument", message, place, 'remove "args"')
        return None if "macro" in entry or texts else foreign

    def _warn(self, rule: str, message: str, span: Span, help: str, include: IncludedRobot) -> None:
        self._report(Diagnostic(rule, WARNING, message, span, (), help), include.via.parent)

    def _report(self, diagnostic: Diagnostic, via: Instance | None, ahead: bool = False) -> None:
        message, help = diagnostic.message, diagnostic.help
        for pattern, replacement in _WORDS:
            message, help = pattern.sub(replacement, message), pattern.sub(replacement, help)
        stack = tuple(via.stack()) if via else ()
        # An unreadable file is reported at its include: do not list that include as a related position as well.
        stack = stack[1:] if stack and diagnostic.span == stack[0].span else stack
        reported = replace(diagnostic, message=message, help=help, related=(*diagnostic.related, *stack))
        if ahead and self.tell is not None:
            if diagnostic.message not in self.told:
                self.tell(reported)
            self.told.add(diagnostic.message)
        elif diagnostic.numbers != TRUSTED:
            self.diagnostics.append(reported)

    def _with_meshes(self, made: Map, include: IncludedRobot) -> Map:
        """Make the mesh paths of a robot relative to its artifacts; warn about meshes that are missing there."""
        entry, names = include.entry, relative_files(made)
        file, folder = Path(entry["file"]).name, entry.get("meshes")
        if folder is not None:
            if not names:
                message = f'"meshes" has no effect: {file} names no mesh or texture by a relative path'
                self._warn("ignored-key", message, entry.key_spans["meshes"], "remove meshes", include)
            return move_files(made, folder)
        base = Path(os.path.abspath(made.span.source.path)).parent
        places = {name: os.path.normpath(base / name) for name in names}
        # Paths in artifacts are relative to the innermost folder that contains the robot and all meshes.
        top = Path(os.path.commonpath([base, *places.values()]))
        above = [folder for folder in (base, *base.parents) if folder.is_relative_to(top)]
        new = {name: Path(os.path.relpath(path, top)).as_posix() for name, path in places.items()}
        homes = {name: [folder for folder in above if files.is_file(folder / found)] for name, found in new.items()}
        if missed := [name for name in names if homes[name] != [top]]:  # missing in ``top``, or also in another folder
            message = f"paths of meshes or textures are relative to {file}, not to the artifacts: {first_of(missed, 1)}"
            help = 'write "meshes: FOLDER", relative to the artifacts, or "meshes: package://NAME"'
            self._warn("include-mesh-path", message, entry.value_spans["file"], help, include)
        return map_files(made, lambda name: name if name in missed else new.get(name, name)) if new else made

    def _attached(self, made: Map, foreign: ImportedRobot, include: IncludedRobot) -> Map:
        """Add the joint that attaches the root of a robot to ``parent``, unless a macro already creates this joint."""
        entry, via = include.entry, include.via
        is_on_parent = foreign.mount != "" and foreign.mount == entry.get("parent")
        others = (*foreign.passed, "publisher") if is_on_parent else foreign.passed
        keys = [key for key in ("parent", "xyz", "rpy", "joint", "publisher") if entry.get(key) is not None]
        keys = [key for key in keys if key not in others]
        have = made.get("joints") or Map(made.span)
        if foreign.mount or "parent" not in keys:
            if keys:
                attached = f'the macro attaches its links to "{foreign.mount}" itself'
                attached = attached if foreign.mount else 'without "parent", the robot is not attached to a frame'
                help = f'remove "{keys[0]}"' if foreign.mount else 'write "parent: FRAME"'
                message = f'"{keys[0]}" of the entry of "include" has no effect: {attached}'
                self._warn("ignored-key", message, entry.key_spans[keys[0]], help, include)
            if is_on_parent:  # report errors in these values at the include that sets them
                made["joints"] = joints = copy(have)
                for name, joint in have.items():
                    if joint["parent"] == entry["parent"]:
                        joints[name] = joint = joint.copy()
                        for key in ("parent", "xyz", "rpy", "publisher"):
                            if entry.get(key) is not None and (key == "publisher" or joint.get(key) == entry[key]):
                                joint.put_from(entry, key)
            return made
        children = {joint["child"] for joint in have.values()}
        root = next(str(link) for link in made["links"] if link not in children)
        name = f"{root}_joint"
        while name in have:
            name = name.removesuffix("_joint") + "_mount_joint"
        name = entry.get("joint") or name
        if name in have:
            message, help = f'joint "{name}" is defined twice', 'write "joint: NAME" in the entry of "include"'
            self._report(error("duplicate-name", message, have.key_spans[name], help), via)
            raise EvaluationFailed
        span = entry.value_spans["parent"]
        joint = Map(span, via.parent)
        joint.put("type", "fixed", span, span)
        joint.put("child", root, span, span)
        for key in (key for key in keys if key != "joint"):
            joint.put_from(entry, key)
        named = entry.value_spans["joint" if entry.get("joint") else "parent"]
        joints = Map(made.span)
        joints.put(name, joint, named, named)
        for other in have:
            joints.put_from(have, other)
        made.put("joints", joints, made.span, made.span)
        return made

    def settle(self, tree: Map) -> None:
        """Copy simulation settings of included robots, such as the integrator, to MJCF outputs of the description."""
        outputs = tree["outputs"] if isinstance(tree.get("outputs"), Map) else {}
        names = [name for name, one in outputs.items() if isinstance(one, Map) and backend_of(name, one) == _MJCF]
        for include, robot in self.included if names else ():
            entry, span = include.entry, include.entry.span
            settings = (robot.get("outputs") or {}).get(_MJCF) or {}
            is_free, is_attached = settings.get("base") == "free", entry.get("parent") is not None
            lost = ["a free base, because the file has a parent"] if is_free and is_attached else []
            is_only = len(self.included) == 1
            tree["outputs"] = outputs = copy(tree["outputs"])
            for name in names:
                output = outputs[name] = copy(outputs[name])
                options = copy(output["option"]) if isinstance(output.get("option"), Map) else Map(output.span)
                for key, value in (settings.get("option") or {}).items():
                    if (key, value) != _DEFAULT or (key in options and not is_only):
                        options.setdefault_at(key, value, span)
                        lost += [] if options[key] == value else [f"{key} {value}"]
                if options:
                    output.put("option", options, span, span)
                if settings.get("contacts") and is_only and _moving_joints(tree) <= _moving_joints(robot):
                    output.setdefault_at("contacts", settings["contacts"], span)
                if is_free and not is_attached:
                    output.setdefault_at("base", "free", span)
                    lost += [] if output["base"] == "free" else ["a free base"]
                    if output["base"] == "free" and is_only and "root" in robot:
                        tree.setdefault_at("root", robot["root"], span)
            if lost:
                file = Path(entry["file"]).name
                message = f"the MJCF does not have these settings of {file}: {first_of(lost, _FEW)}"
                help = "the output or another included file has different settings; set them in the output"
                self._warn("include-settings", message, entry.value_spans["file"], help, include)
            if not (is_only and not (is_free and is_attached) and _moving_joints(tree) <= _moving_joints(robot)):
                self._drop_states(tree, robot, include)

    def _drop_states(self, tree: Map, robot: Map, include: IncludedRobot) -> None:
        """Remove lists with a value for each coordinate of an included MJCF, if the robot has other coordinates."""
        prefix, lost, poses = include.entry.get("prefix") or "", list[str](), copy(tree.get("poses") or Map(tree.span))
        for name in (prefix + name for name in robot.get("poses") or ()):
            if isinstance(poses.get(name), Map) and poses[name].get("mjcf"):
                poses[name] = pose = poses[name].copy()
                lost.append(f'{phrase(pose.pop("mjcf"))} of pose "{name}"')
        if lost:
            tree["poses"] = poses
            file = Path(include.entry["file"]).name
            message = f"the MJCF does not have these values of {file}: {first_of(lost, _FEW)}"
            help = "they have one value for each coordinate of the file: list those of the whole robot in its own pose"
            self._warn("include-settings", message, include.entry.value_spans["file"], help, include)


def _moving_joints(tree: Map) -> int:
    joints = (tree.get("joints") or {}).values()
    return sum(isinstance(joint, Map) and joint.get("type") != "fixed" for joint in joints)


def _check_include(entry: Map, scope: Scope) -> None:
    good = check_include(entry, scope, _KINDS, _KEYS)
    if "with" in entry and "macro" not in entry:
        message = '"with" passes values to a macro, but the entry has no "macro"'
        help = 'add "macro: NAME", or use "args" to pass arguments to a file'
        scope.report("missing-key", message, place_of(entry, "with", scope), help)
        good = False
    prefix = entry.get("prefix")
    if isinstance(prefix, str) and not re.fullmatch(_PREFIX, prefix):
        help = "do not use < > &, quotes or spaces at the ends"
        raise scope.fail("bad-name", f'no name can begin with "{prefix}"', place_of(entry, "prefix", scope), help)
    if hides_letters("prefix", entry, scope) or not good:
        raise EvaluationFailed


def with_prefix(tree: Map, prefix: str, via: Instance) -> tuple[Map, Counter[str]]:
    """Prefix the names in an imported robot; return (sections, number of renamed references in raw XML by name)."""
    fragment = tree.made_by(via).copy()
    for key in (key for key, node in sections().items() if node.whole):
        fragment.pop(key, None)
    if not prefix:
        return place_fragment(fragment, Use(prefix), elements=lambda text: text), Counter()
    names = SymbolTable(fragment)
    things, materials = names.names_of_kinds(THINGS), fragment.get("materials") or ()
    changed: Counter[str] = Counter()

    def rename(name: str) -> str:
        changed[name] += 1
        return prefix + name

    def references(tags: tuple[str, ...], attributes: Mapping[str, str], text: str) -> Iterator[Reference]:
        tag, above = tags[-1], tags[-2] if len(tags) > 1 else "robot"
        for attribute, value in attributes.items():
            is_name = value in things and not (attribute == "name" and tag in _WORDS_OF_OTHERS)
            if attribute == "name" and tag == "material":
                is_name = value in materials
            is_name |= attribute == "name" and (above, tag) in _UNIQUE
            if value and is_name and not _NO_NAMES.search(attribute):
                yield Reference(value, "", attribute, "")
        if text in things and not _NO_NAMES.search(tag):
            yield Reference(text, "", "", "")

    made = place_fragment(fragment, Use(prefix), names, lambda text: Text(rename_references(text, rename, references)))
    if isinstance(made.get("materials"), Map):

        def textured(material: Map) -> Map:  # a texture of MuJoCo is defined in ``mjcf``
            mjcf = material.get("mjcf") or Map(material.span)
            changed = {"mjcf": mjcf.with_changes({"texture": prefix + mjcf["texture"]})} if "texture" in mjcf else {}
            return material.with_changes(changed)

        made["materials"] = map_table(made["materials"], lambda name: prefix + name, textured)
    if isinstance(made.get("accept"), Seq):
        accept = Seq(made["accept"].span, made["accept"].via)
        for entry, span in zip(made["accept"], made["accept"].value_spans, strict=True):
            if entry["rule"] != "owns-world-frame":  # a frame with a prefix is not a world frame
                names_of = map_items(entry.get("of", Seq(span)), lambda name: prefix + name if name in things else name)
                accept.put(entry.with_changes({"of": names_of} if "of" in entry else {}), span)
        made["accept"] = accept
    return made, changed


def map_files(tree: Map, rename: Callable[[str], str]) -> Map:
    """Return the tree of a robot with each mesh or texture file name replaced by ``rename(name)``."""
    made = tree.copy()
    for key, value in tree.items():
        if key != "outputs":  # "file" in outputs names an artifact
            made[key] = _mapped(value, rename, key)
    return made


def relative_files(tree: Map) -> list[str]:
    """Return the relative mesh and texture file names in the tree of a robot, without duplicates."""
    names: dict[str, str] = {}
    map_files(tree, lambda name: names.setdefault(name, name))
    return [name for name in names if not re.match(_ABSOLUTE, name)]


def move_files(tree: Map, folder: str) -> Map:
    """Return the tree of a robot with ``folder`` prepended to each relative mesh or texture file name."""
    return map_files(tree, lambda name: name if re.match(_ABSOLUTE, name) else f"{folder.rstrip('/')}/{name}")


def _mapped(node: Any, rename: Callable[[str], str], key: str) -> Any:
    if isinstance(node, Map):
        made = node.copy()
        for name, value in node.items():
            # Under ``mjcf``, the values of these keys are names of textures, not files.
            is_file = key != "mjcf" and name in ("file", "texture") and isinstance(value, str)
            made[name] = rename(value) if is_file else _mapped(value, rename, name)
        return made
    if isinstance(node, Seq):
        return map_items(node, lambda item: _mapped(item, rename, key))
    return with_files(node, rename) if key in OF_MJCF and isinstance(node, str) else node
