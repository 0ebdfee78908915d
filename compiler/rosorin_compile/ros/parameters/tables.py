"""What is known of nodes: their keys, types and defaults, as ``ros2_nodes.json`` and ``ros2_controllers.json`` have it.

The ``about`` of each file says what its fields mean, and where its facts are from. They are read when a node is looked
at. Validators are those of ``PickNikRobotics/generate_parameter_library`` and two of joint_trajectory_controller
(``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY, described_by
from rosorin_compile.model import Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.source.diagnostics import Help, Suggestion, listed, quoted

from ..ports import TF, drive_plugins, facts, port_of

_WORDS = {"bool": "true or false", "int": "a whole number", "double": "a double", "string": "a text"}
_MANY = {"bool": "booleans", "int": "whole numbers", "double": "doubles", "string": "texts"}


def fits(value: Any, kind: str) -> bool:
    """Say whether a value is of a type of the tables, as rcl takes it: 1 is no double.

    >>> fits(1, "double"), fits(1.0, "double"), fits([1, 2.0], "double_array"), fits("a", "string or string_array")
    (False, True, False, True)
    """
    return any(_is(value, one) for one in kind.split(" or "))


def _is(value: Any, kind: str) -> bool:
    if kind == "none":
        return True
    if kind.endswith("_array"):
        return isinstance(value, (list, tuple)) and all(_is(item, kind.removesuffix("_array")) for item in value)
    kinds: Mapping[str, Any] = {"bool": bool, "int": int, "double": float, "string": str}
    return isinstance(value, kinds[kind]) and (kind == "bool" or not isinstance(value, bool))


def converted(value: Any, kind: str) -> Any:
    """Return a value as its type wants it written, where that is the same number; else the value itself."""
    for one in kind.split(" or "):
        if one.endswith("_array") and isinstance(value, (list, tuple)):
            return [converted(item, one.removesuffix("_array")) for item in value]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if one == "double" and is_number:
            return float(value)
        if one == "int" and isinstance(value, float) and value.is_integer():
            return int(value)
    return value


def type_in_words(kind: str) -> str:
    """Return a type of the tables as a message has it."""

    def one(word: str) -> str:
        base, _, many = word.partition("_")
        return f"a list of {_MANY[base]}" if many else _WORDS[base]

    return " or ".join(map(one, kind.split(" or ")))


def value_text(value: Any) -> str:
    """Return a value of a wrong type as a message has it."""
    if isinstance(value, (list, tuple)):
        kinds = {"int": "int", "float": "double", "str": "string", "bool": "bool"}
        found = dict.fromkeys(_MANY.get(kinds.get(type(item).__name__, ""), "other things") for item in value)
        return f"a list of {listed(found)}" if found else "an empty list"
    return "nothing" if value is None else f"the text {written(value)}" if isinstance(value, str) else written(value)


def as_type(value: Any, kind: str) -> str:
    """Return the fix for a value of the wrong type."""
    made = converted(value, kind)
    if kind == "string" and not isinstance(value, (list, tuple)):
        made = written(value)
    elif kind == "string_array":
        made = [value]
    elif isinstance(value, str) and kind in _WORDS:
        return f"write {type_in_words(kind)} without quotes"
    return f"write {written(made) if fits(made, kind) else type_in_words(kind)}"


def written(value: Any) -> str:
    """Return a value as YAML has it, in one line."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value)
    return f'"{value}"' if isinstance(value, str) else str(value)


def refused(valid: Mapping[str, Sequence[Any]], value: Any) -> tuple[str, Help] | None:
    """Return why validators refuse a value of its type, and the fix; None if they accept it."""
    for name, arguments in valid.items():
        why, help = _refused(name.removeprefix("control_filters::"), value, list(arguments))
        if why:
            return why, help
    return None


def _refused(name: str, value: Any, arguments: list[Any]) -> tuple[str, Help]:
    bound = _BOUNDS.get(name.removesuffix("_or_nan"))
    if bound is not None:
        holds, words = bound
        is_free = name.endswith("_or_nan") and math.isnan(value)
        wrong = not is_free and not holds(value, arguments[0])
        return (f"is {written(value)}, and has to be {words} {arguments[0]:g}" if wrong else ""), ""
    if name in _SIZES:
        fits_size, words = _SIZES[name]
        sizes = " or ".join(map(str, arguments))
        fitting = any(fits_size(len(value), size) for size in arguments)
        return ("" if fitting else f"has {len(value)} values, and needs {words}{sizes}"), ""
    allowed = arguments[0] if arguments else ()
    if name == "one_of" and value not in allowed:
        return f"cannot be {written(value)}", Suggestion(str(value), [*map(str, allowed)])
    if name == "subset_of" and (others := [str(one) for one in value if one not in allowed]):
        return f"cannot have {quoted(others)}", Suggestion(others[0], [*map(str, allowed)])
    if name == "not_empty" and not len(value):
        return "is empty", ""
    if name == "unique" and (twice := [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]):
        return f"has {quoted(twice)} twice", ""
    return _combination(name.rpartition("::")[2], set(value) if isinstance(value, (list, tuple)) else set()), ""


def _combination(name: str, words: set[str]) -> str:
    """Return why joint_trajectory_controller refuses a combination of interfaces."""
    lacks_both = "acceleration" in words and not {"position", "velocity"} & words
    if name == "command_interface_type_combinations":
        if "velocity" in words and len(words) > 1 and "position" not in words:
            return "has to have velocity alone, or beside position"
        if lacks_both:
            return "has to have position and velocity beside acceleration"
        return "has to have effort alone" if "effort" in words and len(words) > 1 else ""
    if name == "state_interface_type_combinations":
        if "velocity" in words and "position" not in words:
            return "has to have position beside velocity"
        if "acceleration" in words and not {"position", "velocity"} <= words:
            return "has to have position and velocity beside acceleration"
    return ""


_BOUNDS: Mapping[str, tuple[Callable[[float, float], bool], str]] = {
    "gt": (operator.gt, "above"),
    "gt_eq": (operator.ge, "at least"),
    "lt_eq": (operator.le, "at most"),
}
_SIZES: Mapping[str, tuple[Callable[[int, int], bool], str]] = {
    "fixed_size": (operator.eq, ""),
    "size_gt": (operator.gt, "more than "),
    "size_lt": (operator.lt, "fewer than "),
}


# The distributions that the tables have; "" for a distribution is any of them.
DISTRIBUTIONS = (HUMBLE, JAZZY)
MANAGER = "controller_manager"
# Keys that every node has, and those below which any name may stand.
_ANY_NODE = ("use_sim_time", "start_type_description_service")
_ANY_BELOW = ("qos_overrides.", "diagnostic_updater.", "bond_heartbeat_period", "service_introspection_mode")
_VARIABLE = re.compile(r"(__map_\w+|<[a-z]+>)")


class Key(NamedTuple):
    """A parameter that a kind of node has. ``name`` may have pieces such as <n>, which stand for many names.

    ``valid`` are its validators with their arguments, ``forced`` is what sets it whatever a file says. ``frame`` says
    what the frame is for that it names, empty if it names none; ``only`` the distributions that know it, and ``stock``,
    if not empty, those whose stock plug-in has it. Without one that is ``needed`` its node does not start.
    """

    name: str
    type: str
    default: Any = None
    valid: Mapping[str, list[Any]] = {}
    only: tuple[str, ...] = DISTRIBUTIONS
    frame: str = ""
    forced: str = ""
    needed: bool = False
    stock: tuple[str, ...] = ()

    @property
    def many(self) -> bool:
        """Whether it is a pattern for keys of many names."""
        return "<" in self.name or "__map_" in self.name


@cache
def _pattern(name: str) -> re.Pattern[str]:
    pieces = _VARIABLE.split(name)
    kinds = {"<n>": r"(\d+)"}
    return re.compile(
        "".join(kinds.get(piece, r"([^.]+)") if odd % 2 else re.escape(piece) for odd, piece in enumerate(pieces))
    )


@dataclass(frozen=True)
class Kind:
    """A kind of node, with its keys by name; ``complete`` says that it has no others.

    The keys are those of all distributions; types and defaults are of the one that was asked for. ``names`` are those
    that the node usually has, ``signs`` keys by which one of another name is known. ``transform`` names the keys of the
    parent, the child and the switch of the transform that it publishes, and ``odometry`` is the topic that a controller
    publishes it on.
    """

    name: str
    keys: Mapping[str, Key]
    distribution: str = ""
    packages: tuple[str, ...] = ()
    complete: bool = False
    names: tuple[str, ...] = ()
    signs: tuple[str, ...] = ()
    strips_slash: bool = False
    odometry: str = ""
    transform: Mapping[str, str] = field(default_factory=dict)

    def key(self, name: str) -> Key | None:
        """Return what is known of a parameter; of several keys that fit the one without variables."""
        return self.keys.get(name) or next((key for key in self._many if _pattern(key.name).fullmatch(name)), None)

    @cached_property
    def _many(self) -> list[Key]:
        return [key for key in self.keys.values() if key.many]

    def __contains__(self, name: str) -> bool:
        key = self.key(name)
        return key is not None and self.has(key)

    def has(self, key: Key) -> bool:
        """Say whether the distribution that was asked for knows a key."""
        return not self.distribution or self.distribution in key.only

    def writes(self, key: Key) -> bool:
        """Return True if files for the distribution may have a key: it or its stock plug-in knows it."""
        return self.has(key) and (not key.stock or self.distribution in key.stock)

    def own(self) -> Iterator[Key]:
        """Yield the keys that the distribution knows."""
        return filter(self.has, self.keys.values())

    def mapped(self, name: str) -> tuple[str, str]:
        """Return the list whose values are keys, and the one that a key has: ("joints", "joint1") of gains.joint1.p."""
        key = None if name in self.keys else self.key(name)
        match = _pattern(key.name).fullmatch(name) if key is not None and "__map_" in key.name else None
        return (key.name.partition("__map_")[2].partition(".")[0], match[1]) if key and match else ("", "")

    def like(self, name: str) -> set[str]:
        """Return the keys that a person may have meant by one: those of many names as they would stand here."""
        words = name.split(".")
        numbers = re.findall(r"\d+", name)
        found = set()
        for key in self.own():
            if not key.many:
                found.add(key.name)
            elif "<n>" in key.name:
                found |= {key.name.replace("<n>", number) for number in numbers}
            elif key.name.count(".") == len(words) - 1:
                pairs = zip(key.name.split("."), words, strict=True)
                found.add(".".join(word if _VARIABLE.fullmatch(piece) else piece for piece, word in pairs))
        return found


def is_of(name: str, kind: Kind | None, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
    """Say whether a node is the one that a description calls a publisher: by its name, else by its package.

    A node that is another publisher by its name is not this one by its package.
    """
    if publisher.kind != NODE or name == publisher.name:
        return publisher.kind == NODE
    named = any(name == other.name for other in publishers)
    return not named and kind is not None and publisher.package in kind.packages


def is_of_all_nodes(key: str) -> bool:
    """Say whether every node has a parameter."""
    return key in _ANY_NODE or key.startswith(_ANY_BELOW)


def _of_distribution(distribution: str) -> str:
    return described_by(distribution) if distribution else ""


@cache
def kinds(distribution: str) -> Mapping[str, Kind]:
    """Return the kinds of nodes beside controllers, by name."""
    distribution = _of_distribution(distribution)
    return {name: _kind(name, entry, distribution) for name, entry in facts("ros2_nodes")["nodes"].items()}


def _kind(name: str, entry: Mapping[str, Any], distribution: str) -> Kind:
    return Kind(
        name,
        {key: _key_of_node(key, of, distribution) for key, of in entry["keys"].items()},
        distribution,
        (entry["package"],),
        entry["complete"],
        tuple(entry["names"]),
        tuple(entry["signs"]),
        entry.get("strips_slash", False),
        transform=entry.get("transform", {}),
    )


def _key_of_node(name: str, entry: Mapping[str, Any], distribution: str) -> Key:
    valid: dict[str, list[Any]] = {}
    lengths = entry.get("length")
    if isinstance(lengths, dict):
        lengths = lengths.get(distribution) or sorted({one for some in lengths.values() for one in some})
    if lengths:
        valid["fixed_size"] = lengths
    if "one_of" in entry:
        valid["one_of"] = [entry["one_of"]]
    only = tuple(entry.get("only", DISTRIBUTIONS))
    stock = tuple(entry.get("stock", ()))
    return Key(name, entry["type"], entry.get("default"), valid, only, entry.get("frame", ""), stock=stock)


# The packages that a description may name for a controller: that which starts it is as good as its own.
_OF_CONTROLLERS = ("ros2_controllers", "ros2_control", MANAGER)
_TRANSFORM = {"parent": "odom_frame_id", "child": "base_frame_id", "switch": "enable_odom_tf"}


def plugins(distribution: str) -> Mapping[str, str]:
    """Return every type of controllers, with a table or without, with its package."""
    distribution = _of_distribution(distribution)
    tables = [facts("ros2_controllers")[one] for one in DISTRIBUTIONS if distribution in ("", one)]
    return {plugin: package for one in tables for plugin, package in one["plugins"].items()}


@cache
def controller(plugin: str, distribution: str) -> Kind | None:
    """Return what is known of a type of controllers; None if nothing is.

    A distribution that does not have it gives what the other one knows.
    """
    of_tables = _of_distribution(distribution)
    tables = {one: entries for one in DISTRIBUTIONS if (entries := _entries_of(plugin, one))}
    if not tables:
        return None
    chosen = of_tables if of_tables in tables else ""
    of_all = facts("ros2_nodes")["controllers"]
    frame_id = of_all["frame_ids"].get(plugin, "")
    frames = {"odom_frame_id": "odom", "base_frame_id": "base", frame_id: "sensor"}
    keys = _keys_of_controllers(tables, chosen, frames)
    if distribution not in ("", *DISTRIBUTIONS):
        removed = of_all["removed_after_jazzy"].get(plugin, ())
        keys = {name: _later(key, distribution, removed) for name, key in keys.items()}
        chosen = distribution
    for name in of_all["without_effect"].get(plugin, ()):
        keys[name] = keys[name]._replace(only=(*DISTRIBUTIONS, distribution), stock=keys[name].only)
    port = port_of(plugin, "", TF)
    odometry = port.topic if port else ""
    packages = (plugins("")[plugin], *_OF_CONTROLLERS)
    transform = of_all["transforms"].get(plugin) or (_TRANSFORM if odometry else {})
    return Kind(plugin, keys, chosen, packages, complete=True, odometry=odometry, transform=transform)


def _later(key: Key, distribution: str, removed: Iterable[str]) -> Key:
    last = key.name.rpartition(".")[2]
    return key if JAZZY not in key.only or last in removed else key._replace(only=(*key.only, distribution))


def _entries_of(plugin: str, distribution: str) -> dict[str, Mapping[str, Any]]:
    data = facts("ros2_controllers")[distribution]
    if plugin not in data["plugins"] or plugin not in data:
        return {}
    of_manager = {name.partition(".")[2]: entry for name, entry in data[MANAGER].items() if name.startswith("<name>.")}
    plain = {name: {"is": "", **entry} for name, entry in (of_manager | data["every_controller"]).items()}
    own: Mapping[str, Mapping[str, Any]] = data[plugin]
    return {**plain, **own}


def _keys_of_controllers(
    tables: Mapping[str, Mapping[str, Mapping[str, Any]]], chosen: str, frames: Mapping[str, str]
) -> dict[str, Key]:
    found: dict[str, Key] = {}
    for one in [*tables, chosen] if chosen else tables:
        for name, entry in tables[one].items():
            default = entry.get("default")
            if entry["type"] == "double" and isinstance(default, str):
                default = float(default)
            only = tuple(other for other in tables if name in tables[other])
            key = Key(name, entry["type"], default, entry.get("valid", {}), only, frames.get(name, ""))
            optional = "is" in entry or "forced" in entry or key.type == "none" or key.many
            needed = not optional and ("default" not in entry or refused(key.valid, default) is not None)
            found[name] = key._replace(forced=entry.get("forced", ""), needed=needed)
    return found


@cache
def manager(distribution: str) -> Kind:
    """Return the controller_manager, with the keys that it has of each controller (<name>.type)."""
    distribution = _of_distribution(distribution)
    tables = {one: facts("ros2_controllers")[one][MANAGER] for one in DISTRIBUTIONS}
    keys = _keys_of_controllers(tables, distribution, {})
    optional = {name: key._replace(needed=False) for name, key in keys.items()}
    return Kind(MANAGER, optional, distribution, (MANAGER,), complete=True)


def by_signs(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the kind that has most of its signs among some keys; None if none has any."""

    def count(kind: Kind) -> int:
        return sum(sign in keys for sign in kind.signs)

    best = max(kinds(distribution).values(), key=count)
    return best if count(best) else None


def controller_by_keys(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the controller of a drive that knows most of some keys, where they are those of one."""
    if _TRANSFORM["switch"] not in keys:
        return None
    found = [kind for plugin in drive_plugins() if (kind := controller(plugin, distribution)) is not None]
    return max(found, key=lambda kind: sum(kind.key(name) is not None for name in keys))


def by_name(name: str, distribution: str) -> Kind | None:
    """Return the kind that a node of a name usually is."""
    if name == MANAGER:
        return manager(distribution)
    return next((kind for kind in kinds(distribution).values() if name in kind.names), None)
