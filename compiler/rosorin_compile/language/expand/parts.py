"""Parts and sensor types: reusable pieces of a description with parameters.

A ``use`` entry refers to a part by ``NAME`` (in ``parts`` of the description), ``FILE/NAME`` (in the library that ships
with the tool) or ``PACKAGE:FILE/NAME`` (in a YAML file of an installed Python package).

A sensor type has parameters (``params``, set by ``with`` in a sensor), named values (``let``) and default values for
keys of its sensors. Its expressions may use the ``name``, ``frame`` and ``parent`` of the sensor.
"""

import sys
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Source, Span, Suggestion, nearest
from rosorin_compile.source.load import LoadError, load_mapping, load_own
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.tree import Instance, Map, Place, Seq
from rosorin_compile.source.wording import suggest
from rosorin_compile.source.xml.elements import found_in

from ..annotations import ENTRIES
from ..schema import keys_of_xml, merged_sections, of_parts, of_types
from ..suggestions import word_meant
from ..symbols import MOUNT, SymbolTable
from . import declarations
from .declarations import declare
from .placing import Use, copy, join, place_fragment, with_source
from .scope import EvaluationFailed, Scope, key_place, value_place

MAX_NESTED = 40
INSTANCE = 20  # each instance of a part counts as this number of values, plus the values in its sections


class Part(NamedTuple):
    """A part as written in YAML, and the scope of the file that defines it."""

    name: str
    body: Map
    scope: Scope


class Parts:
    """Look up and instantiate parts; ``library`` returns the path of a parts file, or None if it does not exist."""

    def __init__(self, own: Any, scope: Scope, library: Callable[[str], Path | None]) -> None:
        self.own = own if isinstance(own, Map) else Map(Span(Source("", ""), 1, 1))
        self.scope, self.expansion, self.library = scope, scope.expansion, library
        self.files: dict[Path, tuple[Map, Scope] | None] = {}
        self.sound: dict[int, bool] = {}
        self.found: dict[str, Part] = {}

    def use(self, tree: Map, entries: Map, scope: Scope, depth: int = 0) -> bool:
        """Instantiate the part of each ``use`` entry and add it to the tree; return True if there are no errors."""
        good, via = True, scope.via or entries.via
        for key, item in entries.items():
            place = Place(entries.key_spans[key], via)
            try:
                # Check before evaluation, which would treat a section with a misplaced ``for`` as a loop.
                content = item.get("content") if isinstance(item, Map) else None
                owner, sections = f' in "content" of entry "{key}" of "use"', merged_sections(ENTRIES, in_parts=True)
                if isinstance(content, Map) and not declarations.check_controls(owner, content, sections, scope):
                    raise EvaluationFailed
                for inner, entry in scope.entries(item, key, is_use=True):
                    name = inner.name(key, *place) if "$" in key else key
                    resolved = inner.resolve(entry, Place(entries.value_spans[key], via))
                    fragment = self.instance(name, resolved, inner, place, depth)
                    size = sum(map(len, filter(None, fragment.values())))
                    scope.count(size, *place)
                    good &= join(tree, fragment, scope, parts=True)
            except EvaluationFailed:
                good = False
        return good

    def instance(self, name: str, entry: Any, scope: Scope, place: Place, depth: int = 0) -> Map:
        """Return the sections that a ``use`` entry creates. Raises EvaluationFailed after reporting errors."""
        if not isinstance(entry, Map):
            message = f'the entry "{name}" of "use" must be a mapping that names a part'
            raise scope.fail("wrong-type", message, place, 'write "part: NAME"')
        self.expansion.parts += 1
        declarations.check_use(name, entry, scope)
        if not isinstance(entry.get("part"), str):
            help = 'name a part of "parts" or of the library'
            raise scope.fail("missing-key", f'the entry "{name}" of "use" needs the key "part"', place, help)
        if entry["part"] not in self.found:
            where = Place(entry.value_spans["part"], scope.via or entry.via)
            self.found[entry["part"]] = self._look_up(entry["part"], scope, where)
        part = self.found[entry["part"]]
        scope.count(INSTANCE * (1 + depth), *place)  # nested parts can grow exponentially
        if depth > MAX_NESTED:
            message = f'parts are nested more than {MAX_NESTED} levels deep, at part "{part.name}"'
            scope.report("part-cycle", message, place, 'end the recursion with an "if" in the part')
            self.expansion.nodes, self.expansion.is_full = sys.maxsize, True  # stop here, to report this only once
            raise EvaluationFailed
        prefix = str(entry.get("prefix", f"{name}_") or "")
        message = f'part "{part.name}" used here as "{name}"'
        via = Instance(message, place.span, scope.via or place.via, True, scope.prefix + prefix)
        inner = Scope(self.expansion, part.scope, via)
        inner.prefix = via.prefix
        if entry.get("parent") is not None:
            inner.mount = value_place(entry, "parent")
        at, own = Place(entry.span, entry.via), (part.body.get("params") or (), part.body.get("let") or ())
        inner.bind("name", name, at)
        inner.bind("mirrored", entry.get("mirror") is not None, at)
        if not any("prefix" in names for names in own) and part.scope.owner("prefix") is None:
            inner.bind("prefix", inner.prefix, at)
        _bind(inner, f'part "{part.name}"', part.body, entry, Place(place.span, entry.via))
        fragment, content = self._fragment(part, inner, depth), entry.get("content")
        good = join(fragment, content, inner, parts=True) if isinstance(content, Map) else True
        if not inner.evaluate_rest() or not good:
            raise EvaluationFailed
        names = SymbolTable(fragment)
        if names.contents.uses_mount and entry.get("parent") is None:
            help = 'write "parent: FRAME" with the frame that the part is attached to'
            raise scope.fail("missing-key", f'the entry "{name}" of "use" needs the key "parent"', place, help)
        ignored = [key for key in ("parent", "xyz", "rpy") if entry.get(key) is not None]
        if ignored and not names.contents.uses_mount:
            help = 'write "parent: mount" in a joint or sensor of the part, or remove the key'
            message = f'the entry "{name}" of "use" has "{ignored[0]}", but the part attaches nothing to "{MOUNT}"'
            span, stack = entry.key_spans[ignored[0]], tuple(scope.via.stack()) if scope.via else ()
            self.expansion.diagnostics.append(Diagnostic("ignored-key", WARNING, message, span, stack, help))
        use = Use(prefix, *map(entry.get, ("parent", "xyz", "rpy", "mirror")))
        if use.mirror is not None:
            _check_elements(name, fragment, inner)
        made = place_fragment(fragment, use, names)
        return with_source(made, entry) if "source" in entry else made

    def _fragment(self, part: Part, inner: Scope, depth: int) -> Map:
        body = part.body
        made, good = Map(body.span, inner.via), True
        for section in of_parts():
            if body.get(section) is not None:
                try:
                    place = Place(body.value_spans[section], inner.via)
                    value = copy(inner.resolve(body[section], place, section in keys_of_xml()))
                    made.put(section, value, body.key_spans[section], body.value_spans[section])
                except EvaluationFailed:
                    good = False
        if good and not declarations.check_sections(f'part "{part.name}"', made, inner):
            raise EvaluationFailed
        if isinstance(body.get("use"), Map):
            good &= self.use(made, body["use"], inner, depth + 1)
        if not good:
            raise EvaluationFailed
        return made

    def _look_up(self, name: str, scope: Scope, place: Place) -> Part:
        file, slash, short = name.rpartition("/")
        parts, home = self.own, self.scope
        if slash:
            path = self.library(file)
            if path is None:
                files = ", ".join(sorted(path.stem for path in data_folder("parts_library").glob("*.yaml")))
                help = f'use a library file ({files}), PACKAGE:FILE of a Python package, or "include" your own file'
                raise scope.fail("unknown-part", f'there is no parts file "{file}"', place, self._near(short) or help)
            parts, home = self._load(path, file, place.span)
        if short not in parts:
            places = {f"{file}{slash}{part}": parts.key_spans[part] for part in parts}
            instead, none = self._near(short), 'define it in "parts"'
            suggestion = Suggestion(name, places, instead=instead, none=none, places=places)
            raise scope.fail("unknown-part", f'there is no part "{name}"', place, suggestion)
        body = parts[short]
        if id(body) not in self.sound:
            self.sound[id(body)] = declarations.check_part(short, parts, home)
        if not self.sound[id(body)]:
            raise EvaluationFailed
        return Part(name, body, home)

    def _near(self, short: str) -> str:
        names: dict[str, list[str]] = {}
        for path in sorted(data_folder("parts_library").glob("*.yaml")):
            with suppress(LoadError):
                for part in load_mapping(path, path.name).get("parts") or ():
                    names.setdefault(part, []).append(f"{path.stem}/{part}")
        close = nearest(short, names)
        return suggest(*names[close]) if close else ""

    def _load(self, path: Path, file: str, use: Span) -> tuple[Map, Scope]:
        if path not in self.files:
            self.files[path] = None
            package, _, name = file.rpartition(":")
            shown = f"{package or 'parts'}/{name}.yaml"
            try:
                tree = load_mapping(path, shown, use) if package else load_own(path, shown)
            except LoadError as problem:
                self.expansion.diagnostics.append(problem.diagnostic)
                raise EvaluationFailed from None
            home, kinds = Scope(self.expansion), dict.fromkeys(("let", "parts", "sensor_types"), Map)
            if declarations.check_entry(tree.span.source.path, tree, home, declarations.FILE_KEYS, kinds):
                home.define_all(tree.get("let"))
                self.files[path] = tree.get("parts") or Map(tree.span), home
        loaded = self.files[path]
        if loaded is None:
            raise EvaluationFailed
        return loaded


def _bind(scope: Scope, owner: str, body: Map, entry: Map, user: Place) -> None:
    before, params = len(scope.expansion.diagnostics), body.get("params")
    given = Map(entry.span, entry.via) if entry.get("with") is None else entry["with"]
    if not isinstance(given, Map):
        raise EvaluationFailed  # validation reports the wrong type
    places = ((key, (value_place if key in (params or ()) else key_place)(given, key)) for key in given)
    declare(scope, params, {key: (given[key], place) for key, place in places}, owner, user, body.get("let"))
    if len(scope.expansion.diagnostics) > before:
        raise EvaluationFailed


class ChangedSensor(Seq):
    """The value of the key ``gazebo`` of a sensor, merged with the Gazebo sensor that its sensor type defines.

    ``brought`` is the Gazebo sensor of the type. If the sensor moves it, the MuJoCo elements of the type move with it.
    ``brought`` is None if the sensor defines MuJoCo elements, which replace those of the type.
    """

    __slots__ = ("brought",)
    brought: Map | None


def apply_types(tree: Map, own: Any, scope: Scope, library: Path) -> None:
    """Add the values of sensor types to the sensors; look up types in ``own``, then in the file ``library``."""
    sensors: Any = tree.get("sensors")
    types = own if isinstance(own, Map) else {}
    shared: Any = None
    for name, sensor in list(sensors.items()) if isinstance(sensors, Map) else ():
        kind = sensor.get("type") if isinstance(sensor, Map) else None
        if not isinstance(kind, str):
            continue
        home, definition = scope, types.get(kind)
        if definition is None:
            shared = shared or load_own(library, f"parts/{library.name}")["sensor_types"]
            home, definition = Scope(scope.expansion), shared.get(kind)
        span = sensor.value_spans["type"]
        if not isinstance(definition, Map):
            help = partial(word_meant, kind, [*types, *(shared or {})], "sensor type")
            message = f'sensor "{name}": unknown sensor type "{kind}"'
            scope.report("unknown-sensor-type", message, Place(span, sensor.via), help)
            continue
        via = Instance(f'sensor type "{kind}" of "{name}" used here', span, sensor.via, made=True)
        try:
            full = _with_type(name, kind, sensor, definition, Scope(scope.expansion, home, via))
        except EvaluationFailed:
            continue
        sensors.put(name, full, sensors.key_spans[name], sensors.value_spans[name])


def _with_type(name: str, kind: str, sensor: Map, definition: Map, scope: Scope) -> Map:
    kinds, keys = dict.fromkeys(("params", "let"), Map), ("help", "params", "let", *of_types())
    if not declarations.check_entry(f'sensor type "{kind}"', definition, scope, keys, kinds, "sensor_type"):
        raise EvaluationFailed
    place = Place(sensor.span, sensor.via)
    scope.bind("name", name, place)
    on = "parent" if "parent" in sensor else "frame"  # without a parent, the sensor is on the link ``frame``
    for key, source in (("frame", "frame"), ("parent", on)):
        if sensor.get(source) is None:
            scope.broken.add(key)  # validation reports the missing key
        else:
            scope.bind(key, sensor[source], place)
    _bind(scope, f'sensor type "{kind}"', definition, sensor, Place(sensor.value_spans["type"], sensor.via))
    made = sensor.copy()
    made.pop("with", None)
    is_changed = isinstance(sensor.get("gazebo"), Map)
    for key in of_types():
        if key in definition and (key not in sensor or (key == "gazebo" and is_changed)):
            place = Place(definition.value_spans[key], scope.via)
            value = copy(scope.resolve(definition[key], place, key in keys_of_xml()))
            if isinstance(value, (Map, Seq)):
                value.via = scope.via  # so that error messages name the sensor
            if key in sensor:
                made[key] = value
            elif value is not None:
                made.put(key, value, definition.key_spans[key], definition.value_spans[key])
    if is_changed:
        made["gazebo"] = _changed(made["gazebo"], sensor, kind, scope)
    return made


def _changed(brought: Any, sensor: Map, kind: str, scope: Scope) -> Seq:
    changes = sensor["gazebo"]
    only = brought[0] if isinstance(brought, Seq) and len(brought) == 1 else None
    if not isinstance(only, Map):
        count = len(brought) if isinstance(brought, Seq) else 0
        brings = f"{count} Gazebo sensors" if count else "no Gazebo sensor"
        message = f'sensor type "{kind}" has {brings}, but a mapping in "gazebo" needs exactly one'
        place = Place(sensor.key_spans["gazebo"], sensor.via)
        raise scope.fail("ignored-key", message, place, 'write a list: "gazebo: [{sensor: TYPE, elements: {...}}]"')
    made = ChangedSensor(changes.span, changes.via)
    made.brought = None if "mjcf" in sensor else only
    made.put(_merged(only, changes), changes.span)
    return made


def _merged(base: Map, changes: Map) -> Map:
    made = base.copy()
    made.span, made.via = changes.span, changes.via
    for key, value in changes.items():
        before = made.get(key)
        both = _merged(before, value) if isinstance(before, Map) and isinstance(value, Map) else value
        made.put(key, both, changes.key_spans[key], changes.value_spans[key])
    return made


# MJCF attributes that are positions or directions; ``mirror`` cannot change them.
_SPATIAL = {"pos", "quat", "axis", "axisangle", "euler", "xyaxes", "zaxis", "fromto", "dir", "anchor", "relpose"}


def _check_elements(use: str, fragment: Map, scope: Scope) -> None:
    before = len(scope.expansion.diagnostics)
    entries = fragment["links"].values() if isinstance(fragment.get("links"), Map) else ()
    listed = [fragment.get("mjcf"), *(entry.get("mjcf_elements") for entry in entries if isinstance(entry, Map))]
    for texts in (one for one in listed if isinstance(one, Seq)):
        for text, span in zip(texts, texts.value_spans, strict=True):
            for found in found_in(text) if isinstance(text, str) else ():
                if words := sorted(_SPATIAL.intersection(found.attributes)):
                    message = f'"mirror" of the entry "{use}" of "use" ignores the {words[0]} of <{found.tags[-1]}>'
                    help = "write it with keys of the description, such as sites, or make a part for each side"
                    scope.report("mirrored-element", message, Place(span, scope.via), help)
    if len(scope.expansion.diagnostics) > before:
        raise EvaluationFailed
