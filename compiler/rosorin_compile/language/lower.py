"""Convert an expanded and validated tree to a ``Robot``.

Each section, built-in or from a plug-in, is converted by its ``Section`` object; ``Lowering`` is the state of the
conversion. ``record_of`` fills each field of a dataclass from the key of the same name, so a new key only needs a new
field in the model. Errors are reported only if a value cannot be converted; rules check whether the robot makes sense.
"""

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from graphlib import CycleError, TopologicalSorter
from types import NoneType, UnionType
from typing import Any, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

from rosorin_compile.model import Edge, Inertial, Joint, Link, Pose, Publisher, Robot, Vector
from rosorin_compile.model.sections import ENTRIES, ITEMS, ONE, Section, Sections, own_sections
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.model.simulation import Attribute, Values
from rosorin_compile.source.diagnostics import Diagnostic, Help, Related, UnknownName, error
from rosorin_compile.source.plugins import Plugin, divert_stdout, failed_plugin
from rosorin_compile.source.rule_registry import find_declared
from rosorin_compile.source.tree import Map, Path

from .expand.provenance import problem_at
from .expand.scope import Scope
from .schema import fragment_at, plugin_sections, resolve, schema
from .suppressions import is_accepted, names_at
from .symbols import Symbol, SymbolTable

T = TypeVar("T")
Convert = Callable[[Any], Any]
Report = Callable[[Diagnostic, str], None]
Place = Callable[[str, str, Path], None]
Problem = Callable[..., None]  # a function that reports a problem; parameters: rule, message, path, help
_ACCEPTABLE = {"shape-size": find_declared("shape-size")}


class LoweringError(Exception):
    """Raised if a value cannot be converted; ``path`` is the path of the incorrect value in the tree."""

    def __init__(self, rule: str, message: str, path: Path = (), help: Help = "") -> None:
        super().__init__(message)
        self.rule, self.message, self.path, self.help = rule, message, path, help


class Lowering:
    """The intermediate results of converting a tree to a robot; call the object to report a problem."""

    def __init__(self, tree: Map, scope: Scope | None) -> None:
        self.tree, self.scope = tree, scope
        self.places: dict[tuple[str, str], Path] = {}
        self.frames: dict[str, tuple[str, Path]] = {}  # (child frame, path of its name) by joint name
        self.diagnostics: list[Diagnostic] = []
        self.nodes: dict[str, Publisher] = {}
        self.edges: list[Edge] = []
        self.links: list[Link] = []
        self.joints: list[Joint] = []
        self.urdf_elements: list[str] = []
        self.servos: tuple[ServoGroup, ...] = ()
        self.solids: dict[object, Inertial] = {}  # inertials calculated from meshes, by file and scale
        self._shared: dict[Hashable, Any] = {}

    def __call__(
        self, rule: str, message: str, path: Path, help: Help = "", related: tuple[Related, ...] = (), key: bool = False
    ) -> None:
        """Report a problem with the value at a path of the tree or, if ``key`` is True, with its key."""
        diagnostic = problem_at(self.scope, self.tree, path, rule, message, help, related, key)
        self.diagnostics.append(replace(diagnostic, of=names_at(self.tree, path)))

    def share(self, key: Hashable, make: Callable[[], T]) -> T:
        """Return ``make()``, cached under ``key``; do not cache a result for which problems were reported."""
        if key in self._shared:
            return self._shared[key]  # type: ignore[no-any-return]
        before, made = len(self.diagnostics), make()
        if len(self.diagnostics) == before:
            self._shared[key] = made
        return made

    @contextmanager
    def report_errors(self, where: str = "") -> Iterator[None]:
        """Report a LoweringError that is raised in a ``with`` block, with ``where`` appended to its message."""
        try:
            yield
        except LoweringError as problem:
            self(problem.rule, problem.message + where, problem.path, problem.help)

    def accepts(self, problem: LoweringError) -> bool:
        """Report a problem and return True if ``accept`` of the description suppresses it, otherwise return False."""
        diagnostic = replace(error(problem.rule, "", None), of=names_at(self.tree, problem.path))
        if not is_accepted(self.tree, diagnostic, _ACCEPTABLE):
            return False
        self(problem.rule, problem.message, problem.path, problem.help)
        return True

    def place(self, kind: str, name: str, path: Path) -> None:
        """Record the path where a name is defined; report an error if the name is already defined."""
        first = self.places.get((kind, name))
        if first is None:
            self.places[kind, name] = path
        else:
            related = (Related("first defined here", self.tree.locate(first, key=True).span),)
            self("duplicate-name", f'the {kind} "{name}" is defined twice', path, "rename one of them", related)

    def place_joint(self, name: str, path: Path, frame: str, frame_path: Path) -> None:
        """Record the paths where a joint and its child frame are defined; report a frame with two parent joints."""
        child, first = self.frames.setdefault(name, (frame, frame_path))
        if child != frame or first == frame_path:
            self.place("joint", name, path)
            return
        related = (Related("first defined here", self.tree.locate(first).span),)
        message = f'frame "{frame}" is defined twice: by {owner_of_frame(first)} and by {owner_of_frame(frame_path)}'
        help = 'give each its own "frame"'
        if first[0] == "joints":
            help = f'a sensor also defines the joint to its frame: remove joint "{name}", or use another "frame"'
        self("duplicate-name", message, frame_path, help, related)


def owner_of_frame(path: Path) -> str:
    """Format the joint or sensor that defines a frame for messages; ``path`` is the path of the frame name."""
    what = "joint" if path[0] == "joints" else "sensor"
    return f'{"the optical frame of " if "optical" in path[2:] else ""}{what} "{path[1]}"'


class LoweredRobot(NamedTuple):
    """The result of ``lower``: the robot (None after an error), paths of definitions, and diagnostics.

    ``places`` maps (kind, name) to a path in the tree: ("joint", "lidar_joint") -> ("sensors", "lidar"). If several
    nodes publish a joint, ("edge", "0") is mapped to the path of the publisher for ``Robot.edges[0]``.
    """

    robot: Robot | None
    places: dict[tuple[str, str], Path]
    diagnostics: list[Diagnostic]


def lower(tree: Map, scope: Scope | None = None) -> LoweredRobot:
    """Convert a validated tree to a robot; with ``scope``, report errors at the arguments that cause them."""
    lowering = Lowering(tree, scope)

    def report(diagnostic: Diagnostic, section: str) -> None:
        place = tree.locate((section,), key=True)
        lowering.diagnostics.append(replace(diagnostic, span=place.span, related=place.stack()))

    own = [section for section in own_sections() if tree.get(section.name) is not None]
    values: dict[str, Any] = {section.name: _value(section, tree, lowering) for section in own}
    contents, added = {}, {}
    for plugin, section in plugin_sections().sections:
        if tree.get(section.name) is not None:
            contents[section.name] = _contents(section, tree)
            with _guarded(plugin, section.name, report):  # if the plug-in fails, the section is left out
                added[section.name] = _value(section, tree, lowering)
    sections = Sections(added, contents)
    values |= {"name": tree["robot"], "sections": sections, "root_in_world": values.pop("root", None)}
    values |= {name: tuple(getattr(lowering, name)) for name in ("links", "joints", "edges", "urdf_elements")}
    robot = Robot(**{name: value for name, value in values.items() if value is not None})
    if sections.values:
        robot = with_sections(robot, tree, report, lowering.place)
    refused = [problem for problem in lowering.diagnostics if not is_accepted(tree, problem, _ACCEPTABLE)]
    return LoweredRobot(None if refused else robot, lowering.places, lowering.diagnostics)


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
    if not isinstance(value, Mapping) and (value is not None or not (properties or others)):
        return value
    defaults = {key: inner["default"] for key, one in properties.items() if "default" in (inner := resolve(one))}
    return {key: _completed(properties.get(key, others), item) for key, item in {**defaults, **(value or {})}.items()}


@contextmanager
def _guarded(plugin: Plugin, section: str, report: Report) -> Iterator[None]:
    try:
        with divert_stdout():
            yield
    except (Exception, SystemExit) as fault:
        report(failed_plugin(plugin, fault), section)


def with_sections(robot: Robot, tree: Map, report: Report, place: Place) -> Robot:
    """Return a robot with the links, joints and masses that plug-in sections add.

    Entries may refer to links and joints that other entries or sections add, but not in a cycle; a section with other
    unresolved references adds nothing, and rules report it. ``place`` records the kind, name and path of each addition.
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
    defined = {(symbol.kind, symbol.name): symbol.path[1] for symbol in symbols.definitions(section) if symbol.path[1:]}
    entries = symbols.tree[section]
    names: Iterable[Any] = entries if isinstance(entries, Map) else range(len(entries))
    needs: dict[Any, set[Any]] = {name: set() for name in names}
    for reference in unresolved_references(robot, symbols, section):
        if (reference.kind, reference.name) not in defined:
            return None
        if len(reference.path) > 1:
            needs[reference.path[1]] |= {defined[reference.kind, reference.name]} - {reference.path[1]}
    with suppress(CycleError):
        return list(TopologicalSorter(needs).static_order())
    return None


def unresolved_references(robot: Robot, symbols: SymbolTable, section: str) -> list[Symbol]:
    """Return the references in a section to links and joints that the robot does not have."""
    existing = {"link": robot.link, "joint": robot.joint}
    return [one for one in symbols.references(existing, section) if one.name not in existing[one.kind]]


def _checked(made: object, before: Robot) -> Robot:
    if not isinstance(made, Robot):
        raise TypeError(f"what a section adds to is a Robot again, not {str(made)[:60]!r}")
    types = fragment_at(("joints", "*", "type"))["enum"]
    names, known = {link.name for link in made.links}, {id(joint) for joint in before.joints}
    for joint in (joint for joint in made.joints if id(joint) not in known):
        if missing := [end for end in (joint.parent, joint.child) if end not in names]:
            raise ValueError(f'it adds joint "{joint.name}" at link "{missing[0]}", which does not exist')
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
        if joints[joint.name] > 0 and counts[joint.child] <= 1:  # duplicate links are reported already
            joints[joint.name] -= 1
            path = defined.get(("joint", joint.name)) or defined.get(("link", joint.child)) or (section,)
            place("joint", joint.name, path)


def entries_of(tree: Mapping[str, Any], section: str) -> list[tuple[str, Any]]:
    """Return the entries of a section sorted by name, or in file order if the schema has ``x-ordered``."""
    entries = (tree.get(section) or {}).items()
    return list(entries) if fragment_at((section,)).get("x-ordered") else sorted(entries)


def record_of(kind: Callable[..., T], entry: Mapping[str, Any] | None, /, **given: Any) -> T:
    """Create an instance of the dataclass ``kind`` from the keys of an entry; ``given`` overrides keys.

    Missing keys get the defaults of the fields. A field of type ``Pose`` is set from ``xyz`` (m) and ``rpy`` (rad); a
    field ``values`` gets all remaining keys.
    """
    entry = entry or {}
    converters, poses, has_values = _fields(kind)
    found = {key: converters[key](value) for key, value in entry.items() if key in converters and key not in given}
    found |= {name: pose_of_entry(entry) for name in poses if name not in given}
    if has_values and "values" not in given:
        found["values"] = values_of(entry, ("xyz", "rpy", "source", *converters))
    return kind(**found, **given)


def named_records(kind: Callable[..., T], entries: Mapping[str, Any] | None) -> dict[str, T]:
    """Convert entries to instances of the dataclass ``kind``, by name; a field ``name`` gets the name of the entry."""
    has_name = "name" in _fields(kind)[0]
    items = (entries or {}).items()
    return {str(key): record_of(kind, entry, **({"name": str(key)} if has_name else {})) for key, entry in items}


def _records(kind: Callable[..., T], value: Any) -> tuple[T, ...]:
    if isinstance(value, Mapping):
        return tuple(named_records(kind, value).values())
    items = [value] if isinstance(value, str) else value or ()
    return tuple(record_of(kind, None, name=str(i)) if isinstance(i, str) else record_of(kind, i) for i in items)


def vector_of(value: Any, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    """Convert a list of three numbers to a vector; return ``default`` for None."""
    x, y, z = default if value is None else value
    return (float(x), float(y), float(z))


def pose_of_entry(entry: Mapping[str, Any]) -> Pose:
    """Return the pose that ``xyz`` (m) and ``rpy`` (rad) of an entry define."""
    return Pose(vector_of(entry.get("xyz")), vector_of(entry.get("rpy")))


def plain(value: Any) -> Any:
    """Convert a tree to plain Python: quantities to floats in SI units, lists to tuples; omit the keys ``source``."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items() if key != "source"}
    if isinstance(value, list):
        return tuple(plain(item) for item in value)
    if isinstance(value, float):
        return float(value)
    return str(value) if isinstance(value, str) else value


def values_of(entry: Mapping[str, Any] | None, known: Collection[str] = ()) -> dict[str, Attribute]:
    """Return the keys of an entry, except ``known``, and their values as MJCF attributes sorted by name."""
    return {key: _attribute_of(value) for key, value in sorted((entry or {}).items()) if key not in known}


def renamed_values(entry: Mapping[str, Any], words: Mapping[str, str]) -> dict[str, Attribute]:
    """Return the values of an entry as MJCF attributes; ``words`` maps keys to names of MJCF attributes."""
    return {word: _attribute_of(entry[key]) for key, word in words.items() if key in entry}


def _attribute_of(value: Any) -> Attribute:
    if isinstance(value, list):
        return tuple(_attribute_of(item) for item in value)  # type: ignore[misc]
    if value is None or isinstance(value, bool):
        return value
    return str(value) if isinstance(value, str) else float(value)


@cache
def _fields(kind: Any) -> tuple[dict[str, Convert], tuple[str, ...], bool]:
    types = get_type_hints(kind)
    hints = {field.name: types[field.name] for field in fields(kind)}
    poses = tuple(name for name, hint in hints.items() if hint is Pose)
    converters = {name: _converter(hint) for name, hint in hints.items() if hint is not Pose}
    return converters, poses, hints.get("values") == Values


def _converter(hint: Any) -> Convert:
    if hint == Values:
        return values_of
    if hint is float:
        return float
    kind = get_origin(hint)
    inner = [_converter(one) for one in get_args(hint) if one not in (NoneType, Ellipsis)]
    if kind in (Union, UnionType):
        if len(inner) != 1:
            return plain
        return lambda value: None if value is None else inner[0](value)
    if kind is tuple and is_dataclass(get_args(hint)[0]):
        return partial(_records, get_args(hint)[0])
    if kind is tuple and len(inner) == 1:
        return lambda value: tuple(map(inner[0], value if isinstance(value, (list, tuple)) else [value]))
    if kind is tuple:
        return lambda value: tuple(convert(one) for convert, one in zip(inner, value, strict=True))
    if isinstance(kind, type) and issubclass(kind, Mapping):
        of = get_args(hint)[1]
        if isinstance(of, type) and is_dataclass(of):
            return lambda value: named_records(of, value)
        return lambda value: {key: inner[1](one) for key, one in value.items()}
    if isinstance(hint, type) and is_dataclass(hint):
        return lambda value: record_of(hint, value)
    return lambda value: value
