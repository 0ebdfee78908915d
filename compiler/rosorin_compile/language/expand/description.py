"""Expand a description to one plain tree.

Scopes are lexical: a description (all its files together), each part, each round of a loop. Sections of the same name
are joined: first those of included robots; then the entries of the included files, in the order of the includes; then
those of the including file; then those that parts make, in the order of ``use``.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source.diagnostics import Diagnostic, MadeSpan, Related, Span, Suggestion, error, has_errors
from rosorin_compile.source.load import plain_scalar
from rosorin_compile.source.messages import merge_by_name, move_to_name, offer
from rosorin_compile.source.project import Resolved, data_folder
from rosorin_compile.source.tree import Map, Place, Seq
from rosorin_compile.source.wording import suggest, swaps

from ..annotations import ENTRIES
from ..schema import keys_of_xml, merged_sections, of_parts, schema
from ..symbols import SymbolTable
from ..validate import validate
from .declarations import check_controls, check_part, declare
from .defined_names import check_letters, unused_names
from .files import Reader
from .included_robots import IncludedRobots
from .parts import Parts, apply_types
from .placing import copy, join
from .scope import Failed, Scope

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import RobotReader

    from .included_robots import Tell

_FORMS = {"parts": "write NAME: {links: ..., joints: ...}", "use": "write NAME: {part: ...}"}
_FORMS |= {"sensor_types": "write NAME: {params: ..., mjcf: ...}"}
_NOT_EVALUATED = ("args", "modes")
MAX_SHOWN = 40  # letters of an argument


class Expanded(NamedTuple):
    """The plain tree (None with errors), diagnostics, and the files that were read.

    ``scope`` has the arguments and the named values of the description, None if its first file cannot be read.
    ``resolved`` has the paths that names of packages led to. ``unused`` are warnings about unused declarations, to be
    reported if there are no errors. ``symbols`` are the names of the files.
    """

    tree: Map | None
    diagnostics: list[Diagnostic]
    files: tuple[Path, ...]
    scope: Scope | None = None
    resolved: tuple[Resolved, ...] = ()
    unused: tuple[Diagnostic, ...] = ()
    symbols: SymbolTable | None = None


def expand(
    path: Path,
    arguments: Mapping[str, Any],
    robots: RobotReader | None,
    tell: Tell | None = None,
    packages: Mapping[str, Path] | None = None,
    cache: dict[Any, Any] | None = None,
) -> Expanded:
    """Return the tree of the description whose first file is ``path``.

    ``arguments`` are values by name; texts, as on the command line, are read like scalars of YAML. Those of a ``Map``
    that have a place come from a file. ``tell`` receives warnings before code is executed (``xacro-runs-code``);
    without it, they are among the diagnostics. ``robots`` reads included robots in other formats; without it they are
    left out. ``packages`` are folders of ROS packages by name. ``cache`` keeps parsed files between calls.
    """
    reader = Reader(path, robots, packages, cache)
    root = reader.whole()
    if root is None:
        return Expanded(None, reader.diagnostics, tuple(reader.files))
    scope, expansion = reader.scope, reader.scope.expansion
    scope.values["load()"], scope.values["find()"] = reader.load_function(), reader.find_function()
    for name, value, place, written in reader.lets:
        scope.define(name, value, place, written)
    _declare_arguments(root, arguments, reader, scope)
    included = IncludedRobots(reader, robots, tell) if robots else None
    fragments = list(included.fragments()) if included else []
    tree = _evaluate(root, scope, reader, fragments)
    if tree is not None and included:
        included.settle(tree)
    with expansion.without_limits():
        scope.evaluate_rest()
    offered = [*reader.offered, *(robot.item for robot in reader.robots)]
    symbols = SymbolTable(root, reader.lets, offered, expansion.is_constant)
    check_letters(symbols, scope)
    for file in reader.sourced:  # checked here: the file may have no entry that gets its source
        if isinstance(file["source"], Map) and expansion.is_constant(file["source"]):
            top = Map(root.span)
            top.put("robot", "robot", root.span, root.span)
            top.put("source", file["source"], file.key_spans["source"], file.value_spans["source"])
            expansion.diagnostics += validate(top, {})
    warnings = unused_names(symbols, reader.files) if tree is not None else []
    diagnostics = expansion.diagnostics if tree is not None else _without_misnamed(root, expansion.diagnostics)
    if reader.unread:  # names that an unread file would define are not reported as missing
        diagnostics = [one for one in diagnostics if not _is_missing(one)]
    if has_errors(diagnostics):  # each missing name is reported once, where it is written
        diagnostics = merge_by_name(move_to_name(one, offer(one)) for one in diagnostics)
    diagnostics += included.diagnostics if included else []
    resolved = tuple(dict.fromkeys(reader.resolved))
    return Expanded(tree, diagnostics, tuple(reader.files), scope, resolved, tuple(warnings), symbols)


def _without_misnamed(root: Map, diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics without missing names that are caused by a misspelt section or loop."""
    sections = root.copy()
    for key in (*schema("description")["properties"], *_FORMS):
        sections.pop(key, None)
    misnamed = [one for one in validate(sections, {}) if one.rule == "unknown-key"] if sections else []
    waiting: list[Any] = [root]
    while waiting:
        node = waiting.pop()
        waiting += [one for one in (node.values() if isinstance(node, Map) else node) if isinstance(one, (Map, Seq))]
        for key, value in node.items() if isinstance(node, Map) else ():
            if isinstance(value, Map) and "for" in swaps(key):
                message, place = f'an entry has no key "{key}"', Place(node.key_spans[key], node.via)
                misnamed.append(error("unknown-key", message, place.span, suggest("for"), place.stack()))
    return [*misnamed, *(one for one in diagnostics if not (misnamed and _is_missing(one)))]


def _is_missing(diagnostic: Diagnostic) -> bool:
    missing = diagnostic.message.startswith("there is no value named ")
    return missing or diagnostic.rule in ("unknown-part", "unknown-sensor-type", "unknown-argument")


def _evaluate(root: Map, scope: Scope, reader: Reader, robots: list[Map | None]) -> Map | None:
    own = Map(root.span)
    good = None not in robots
    for key, value in root.items():
        if key in _FORMS:
            continue
        made = value
        try:
            if key not in _NOT_EVALUATED:
                if key in merged_sections(ENTRIES) and not check_controls("", root, (key,), scope):
                    raise Failed
                made = scope.resolve(value, Place(root.value_spans[key], None), key in keys_of_xml())
        except Failed:
            good = False
            continue
        own.put(key, copy(made) if key in of_parts() else made, root.key_spans[key], root.value_spans[key])
    for key, help in _FORMS.items():
        if not isinstance(root.get(key) or {}, dict):
            what = "types" if key == "sensor_types" else "parts"
            scope.report("wrong-type", f"{key} maps names to {what}", Place(root.value_spans[key], None), help)
            good = False
    tree = Map(own.span) if any(robots) else own
    for sections in [*robots, own] if any(robots) else ():
        join(tree, sections or Map(own.span), scope)
    parts = Parts(root.get("parts"), scope, reader.parts_file)
    uses = root.get("use")
    if isinstance(uses, Map):
        good &= check_controls("", root, ("use",), scope) and parts.use(tree, uses, scope)
    for name, body in parts.own.items():  # errors in parts that nothing uses
        if id(body) not in parts.sound:
            check_part(name, parts.own, scope)
    if not good:
        return None
    apply_types(tree, root.get("sensor_types"), scope, data_folder("parts_library") / "sensors.yaml")
    return tree


def _declare_arguments(root: Map, arguments: Mapping[str, Any], reader: Reader, scope: Scope) -> None:
    """Bind the arguments: those of the command line, else those that an include gives, else their defaults."""
    declared = root.get("args")
    declared = declared if isinstance(declared, Map) else Map(root.span)
    given: dict[str, tuple[Any, Place]] = {}
    for name, (value, place) in reader.given.items():
        with suppress(Failed):
            given[name] = scope.resolve(value, place), place
    spans: Mapping[str, Span] = getattr(arguments, "value_spans", {})
    for name, value in arguments.items():
        if name not in declared:
            message = f'the description has no argument "{name}"'
            known, help = getattr(arguments, "key_spans", {}), Suggestion(name, declared, none="it has none")
            scope.expansion.diagnostics.append(error("unknown-argument", message, known.get(name), help))
            continue
        declaration = declared[name]
        kind = declaration.get("type") if isinstance(declaration, Map) else None
        if value == "" and type(value) is str and kind != "text":
            continue  # a launch file cannot leave an argument out: as in xacro, name:= leaves it out
        span = spans.get(name)
        if span is None:  # the command line or Python: the place of the declaration
            span = MadeSpan(*declared.key_spans[name])
            span.via = (Related(f"given to this run: {name}={str(value)[:MAX_SHOWN]}", None),)
        given[name] = _given(value, kind, span), Place(span, None)
    declare(scope, declared, given, "the description")


def _given(value: Any, kind: Any, span: Span) -> Any:
    """Return the value of an argument as part of a tree; items of a Python list or dict get its place."""
    if type(value) is str:
        if kind == "boolean" and value in ("0", "1"):
            return value == "1"
        return value if kind == "text" else plain_scalar(value)
    if type(value) is list:
        items = Seq(span)
        for item in value:
            items.put(_given(item, None, span), span)
        return items
    if type(value) is dict:
        table = Map(span)
        for key, item in value.items():
            table.put(key, _given(item, None, span), span, span)
        return table
    return value
