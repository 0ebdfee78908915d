"""Lower: make the robot from a tree that ``validate`` accepts.

Each section is converted by its record (``Section``), those of plug-ins in the same way. Only what prevents a value
from being made is reported; whether the robot makes sense is for the rules.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from typing import Any, NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.model.sections import ENTRIES, ITEMS, ONE, Section, Sections, own_sections
from rosorin_compile.source.diagnostics import Diagnostic, UnknownName
from rosorin_compile.source.plugins import Plugin, aside, failed_plugin
from rosorin_compile.source.rule_registry import find_declared
from rosorin_compile.source.tree import Map, Path

from .expand.scope import Scope
from .lowering import Lowering
from .records import named_records, plain, record_of
from .schema import fragment_at, plugin_sections, resolve, schema
from .suppressions import is_accepted
from .symbols import Symbol, SymbolTable

Report = Callable[[Diagnostic, str], None]
Place = Callable[[str, str, Path], None]
_ACCEPTABLE = {"shape-size": find_declared("shape-size")}


class Lowered(NamedTuple):
    """The robot (None after an error), where each joint, link and pose is defined, and problems.

    ``places`` is keyed by kind and name: ("joint", "lidar_joint") -> ("sensors", "lidar"); an edge of a publisher of a
    joint that takes turns is named by its index in ``Robot.edges``.
    """

    robot: Robot | None
    places: dict[tuple[str, str], Path]
    diagnostics: list[Diagnostic]


def lower(tree: Map, scope: Scope | None = None) -> Lowered:
    """Return the robot of a tree without errors; ``scope``, if known, is that of its expressions."""
    lowering = Lowering(tree, scope, _ACCEPTABLE)

    def report(diagnostic: Diagnostic, section: str) -> None:
        """Report a problem of the plug-in of a section, at that section."""
        place = tree.locate((section,), key=True)
        lowering.diagnostics.append(replace(diagnostic, span=place.span, related=place.stack()))

    values, sections = _lower_sections(tree, lowering, report)
    values |= {"name": tree["robot"], "sections": sections}
    values |= {name: tuple(getattr(lowering, name)) for name in ("links", "joints", "edges", "urdf_elements")}
    if "root" in values:
        values["root_in_world"] = values.pop("root")
    robot = Robot(**{name: value for name, value in values.items() if value is not None})
    if sections.values:
        robot = with_sections(robot, tree, report, lowering.place)
    refused = [problem for problem in lowering.diagnostics if not is_accepted(tree, problem, _ACCEPTABLE)]
    return Lowered(None if refused else robot, lowering.places, lowering.diagnostics)


def _lower_sections(tree: Mapping[str, Any], lowering: Lowering, report: Report) -> tuple[dict[str, Any], Sections]:
    """Return the values of the sections of the tool by name, and those of plug-ins.

    ``report`` takes a problem of a plug-in and the name of its section, which has no value then.
    """
    own = [section for section in own_sections() if tree.get(section.name) is not None]
    values = {section.name: _value(section, tree, lowering) for section in own}
    contents, added = {}, {}
    for plugin, section in plugin_sections().sections:
        if tree.get(section.name) is not None:
            contents[section.name] = _contents(section, tree)
            with _guarded(plugin, section.name, report):
                added[section.name] = _value(section, tree, lowering)
    return values, Sections(added, contents)


def _value(section: Section[Any], tree: Mapping[str, Any], lowering: Lowering) -> Any:
    if section.lower is not None:
        return section.lower(tree, lowering)
    entries = _contents(section, tree)
    if section.form == ITEMS:
        return tuple(record_of(section.entry, entry) for entry in entries)
    return named_records(section.entry, entries) if section.form == ENTRIES else record_of(section.entry, entries)


def _contents(section: Section[Any], tree: Mapping[str, Any]) -> Any:
    return _completed(schema()["properties"][section.name], plain(tree[section.name]))


def _completed(fragment: Mapping[str, Any], value: Any) -> Any:
    fragment = resolve(dict(fragment))
    properties, others = fragment.get("properties", {}), fragment.get("additionalProperties")
    others = others if isinstance(others, Mapping) else {}
    if isinstance(value, tuple):
        return tuple(_completed(fragment.get("items", {}), item) for item in value)
    if value is None and (properties or others):
        value = {}
    if not isinstance(value, Mapping):
        return value
    resolved = {key: resolve(inner) for key, inner in properties.items()}
    defaults = {key: inner["default"] for key, inner in resolved.items() if "default" in inner}
    return {key: _completed(properties.get(key, others), item) for key, item in {**defaults, **value}.items()}


@contextmanager
def _guarded(plugin: Plugin, section: str, report: Report) -> Iterator[None]:
    try:
        with aside():
            yield
    except (Exception, SystemExit) as fault:
        report(failed_plugin(plugin, fault), section)


def with_sections(robot: Robot, tree: Map, report: Report, place: Place) -> Robot:
    """Return a robot with the links, joints and masses that its sections add.

    An entry may refer to what another entry or section adds, if there is no circle; a section that refers to something
    else adds nothing, which the rules report. ``place`` takes the kind, name and path of what is added.
    """
    made, symbols = robot, SymbolTable(tree)
    waiting = [(plugin, one) for plugin, one in plugin_sections().sections if one.adds and one in robot.sections]
    while ready := [(item, order) for item in waiting if (order := _in_order(made, symbols, item[1].name)) is not None]:
        (plugin, section), order = ready[0]
        waiting.remove((plugin, section))
        before, value = made, robot.sections[section]
        if order and section.form != ONE:
            value = {name: value[name] for name in order} if section.form == ENTRIES else tuple(value[i] for i in order)
        with _guarded(plugin, section.name, report):
            made = _checked(section.adds(made, value), made)  # type: ignore[misc]
        _place_added(before, made, symbols, section.name, place)
    return made if made is robot else replace(made, sections=replace(robot.sections, without=robot))


def _in_order(robot: Robot, symbols: SymbolTable, section: str) -> list[Any] | None:
    """Return the entries of a section, each after those that define what it refers to."""
    defined = {(symbol.kind, symbol.name): symbol.path[1] for symbol in symbols.definitions(section) if symbol.path[1:]}
    needs: dict[Any, set[Any]] = {}
    for reference in unresolved_references(robot, symbols, section):
        if (reference.kind, reference.name) not in defined:
            return None
        if len(reference.path) > 1:
            needs.setdefault(reference.path[1], set()).add(defined[reference.kind, reference.name])
    entries = symbols.tree[section]
    names = entries if isinstance(entries, Map) else range(len(entries))
    try:
        return list(TopologicalSorter({name: needs.get(name, set()) - {name} for name in names}).static_order())
    except CycleError:
        return None


def unresolved_references(robot: Robot, symbols: SymbolTable, section: str) -> list[Symbol]:
    """Return the references of a section to links and joints that do not exist."""
    existing = {"link": robot.link, "joint": robot.joint}
    return [one for one in symbols.references(existing, section) if one.name not in existing[one.kind]]


def _checked(made: object, before: Robot) -> Robot:
    """Return the robot that a section has made. Raises TypeError or ValueError for anything else."""
    if not isinstance(made, Robot):
        raise TypeError(f"what a section adds to is a Robot again, not {str(made)[:60]!r}")
    types = fragment_at(("joints", "*", "type"))["enum"]
    names, known = {link.name for link in made.links}, {id(joint) for joint in before.joints}
    for joint in (joint for joint in made.joints if id(joint) not in known):
        for end in (joint.parent, joint.child):
            if end not in names:
                raise ValueError(f'it adds joint "{joint.name}" at link "{end}", which there is not')
        if joint.type not in types:
            raise UnknownName(f'type for joint "{joint.name}"', joint.type, types)
    return made


def _place_added(before: Robot, made: Robot, symbols: SymbolTable, section: str, place: Place) -> None:
    defined = {(symbol.kind, symbol.name): symbol.path for symbol in symbols.definitions(section)}
    counts = Counter(link.name for link in made.links)
    for name in (counts - Counter(link.name for link in before.links)).elements():
        place("link", name, defined.get(("link", name), (section,)))
    joints = Counter(joint.name for joint in made.joints) - Counter(joint.name for joint in before.joints)
    for joint in reversed(made.joints):
        if joints[joint.name] > 0 and counts[joint.child] <= 1:  # a duplicate link is reported already
            joints[joint.name] -= 1
            path = defined.get(("joint", joint.name)) or defined.get(("link", joint.child)) or (section,)
            place("joint", joint.name, path)
