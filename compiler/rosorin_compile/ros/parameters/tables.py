"""What is known of nodes: their keys, types and defaults, as ``ros2_nodes.json`` and ``ros2_controllers.json`` have it.

The ``about`` of each file says what its fields mean, and where its facts are from. They are read when a node is looked
at. Validators are those of ``PickNikRobotics/generate_parameter_library``, and the combinations of interfaces of
joint_trajectory_controller (``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.model import Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.source.diagnostics import Help, Suggestion, quote

from ..ports import TF, distribution_of_ports, drive_plugins, facts, port_of

DISTRIBUTIONS = (HUMBLE, JAZZY, "kilted")  # those that the tables have; "" for a distribution is any of them
MANAGER = "controller_manager"


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


def convert(value: Any, kind: str) -> Any:
    """Return a value as its type wants it written, where that is the same number; else the value itself."""
    for one in kind.split(" or "):
        if one.endswith("_array") and isinstance(value, (list, tuple)):
            return [convert(item, one.removesuffix("_array")) for item in value]
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if one == "double" and is_number:
            return float(value)
        if one == "int" and isinstance(value, float) and value.is_integer():
            return int(value)
    return value


def type_in_words(kind: str) -> str:
    """Return a type of the tables as a message has it."""
    return " or ".join(facts("ros2_nodes")["types"][one] for one in kind.split(" or "))


def as_type(value: Any, kind: str) -> str:
    """Return the fix for a value of the wrong type."""
    if isinstance(value, str) and kind in ("bool", "int", "double"):
        return f"write {type_in_words(kind)} without quotes"
    made = [value] if kind == "string_array" else convert(value, kind)
    if kind == "string" and not isinstance(value, (list, tuple)):
        made = as_yaml(value)
    return f"write {as_yaml(made) if fits(made, kind) else type_in_words(kind)}"


def as_yaml(value: Any) -> str:
    """Return a value as YAML has it, in one line."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(as_yaml, value))}]"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, float):
        return repr(value)
    return f'"{value}"' if isinstance(value, str) else str(value)


def why_refused(valid: Mapping[str, Sequence[Any]], value: Any) -> tuple[str, Help] | None:
    """Return why validators refuse a value of its type, and the fix; None if they accept it."""
    for name, arguments in valid.items():
        why, help = _refused(name, value, list(arguments))
        if why:
            return why, help
    return None


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


def _refused(name: str, value: Any, arguments: list[Any]) -> tuple[str, Help]:
    """Return why a validator refuses a value, empty if it does not, and the fix."""
    if bound := _BOUNDS.get(name.removesuffix("_or_nan")):
        is_free = name.endswith("_or_nan") and math.isnan(value)
        if not is_free and not bound[0](value, arguments[0]):
            return f"is {as_yaml(value)}, and has to be {bound[1]} {arguments[0]:g}", ""
    elif name in _SIZES:
        fits_size, words = _SIZES[name]
        if not any(fits_size(len(value), size) for size in arguments):
            return f"has {len(value)} values, and needs {words}{' or '.join(map(str, arguments))}", ""
    elif name in ("one_of", "subset_of"):
        values = value if name == "subset_of" else [value]
        if others := [str(one) for one in values if one not in arguments[0]]:
            return f"cannot be {quote(others)}", Suggestion(others[0], [*map(str, arguments[0])])
    elif name == "not_empty" and not len(value):
        return "is empty", ""
    elif name == "unique" and (repeated := [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]):
        return f"has {quote(repeated)} twice", ""
    elif name == "set_of" and set(value) not in map(set, arguments):
        return f"is {as_yaml(value)}, and has to be {' or '.join(map(as_yaml, arguments))}", ""
    return "", ""


# Keys that every node has, and those below which any name may stand.
_ANY_NODE = ("use_sim_time", "start_type_description_service")
_ANY_BELOW = ("qos_overrides.", "diagnostic_updater.", "bond_heartbeat_period", "service_introspection_mode")
_VARIABLE = re.compile(r"(__map_\w+|<[a-z]+>)")


class Key(NamedTuple):
    """A parameter that a kind of node has. ``name`` may have pieces such as <n>, which stand for many names.

    ``valid`` are its validators with their arguments, ``forced`` is what sets it whatever a file says. ``frame`` says
    what the frame is for that it names, empty if it names none; ``only`` the distributions that know it, and ``stock``,
    if not empty, those whose stock plug-in has it. Without one that is ``needed`` its node does not start. ``renamed``
    has values that are refused now, with their replacements.
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
    renamed: Mapping[str, str] = {}

    @property
    def many(self) -> bool:
        """Whether it is a pattern for keys of many names."""
        return "<" in self.name or "__map_" in self.name


@cache
def _pattern(name: str) -> re.Pattern[str]:
    pieces = [re.escape(piece) for piece in _VARIABLE.split(name)]
    pieces[1::2] = [r"(\d+)" if piece == re.escape("<n>") else r"([^.]+)" for piece in pieces[1::2]]
    return re.compile("".join(pieces))


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

    def own_keys(self) -> Iterator[Key]:
        """Yield the keys that the distribution knows."""
        return filter(self.has, self.keys.values())

    def list_of_key(self, name: str) -> tuple[str, str]:
        """Return the list whose values are keys, and the one that a key has: ("joints", "joint1") of gains.joint1.p."""
        key = None if name in self.keys else self.key(name)
        match = _pattern(key.name).fullmatch(name) if key is not None and "__map_" in key.name else None
        return (key.name.partition("__map_")[2].partition(".")[0], match[1]) if key and match else ("", "")

    def like(self, name: str) -> set[str]:
        """Return the keys that a person may have meant by one: those of many names with its words and first number."""
        words, number = name.split("."), next(iter(re.findall(r"\d+", name)), "0")
        found = set()
        for key in self.own_keys():
            pieces = key.name.replace("<n>", number).split(".")
            if not key.many or "<n>" in key.name:
                found.add(".".join(pieces))
            elif len(pieces) == len(words):
                pairs = zip(pieces, words, strict=True)
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


# The packages that a description may name for a controller: that which starts it is as good as its own.
_OF_CONTROLLERS = ("ros2_controllers", "ros2_control", MANAGER)


@cache
def kinds(distribution: str) -> Mapping[str, Kind]:
    """Return the kinds of nodes that are no controllers, by name."""
    found = facts("ros2_nodes")["nodes"]
    return {name: _kind(name, entry, entry["keys"], (entry["package"],), distribution) for name, entry in found.items()}


@cache
def controller(plugin: str, distribution: str) -> Kind | None:
    """Return what is known of a type of controllers, or None.

    A distribution that does not have it gets what others know.
    """
    table = facts("ros2_controllers")
    entry = table["controllers"].get(plugin, {})
    if "keys" not in entry:
        return None
    keys = {**table["every_controller"], **entry["keys"]}
    return _kind(plugin, entry, keys, (entry["package"], *_OF_CONTROLLERS), distribution)


def plugins(distribution: str) -> Mapping[str, str]:
    """Return every type of controllers, with keys or without, with its package."""
    found, one = facts("ros2_controllers")["controllers"], _known(distribution)
    return {plugin: of["package"] for plugin, of in found.items() if not one or one in of.get("only", DISTRIBUTIONS)}


def _known(distribution: str) -> str:
    return distribution_of_ports(distribution) if distribution else ""


def _kind(
    name: str, entry: Mapping[str, Any], keys: Mapping[str, Any], packages: tuple[str, ...], distribution: str
) -> Kind:
    known, port = _known(distribution), port_of(name, "", TF)
    known = known if known in entry.get("only", DISTRIBUTIONS) else ""
    return Kind(
        name,
        {key: _key(key, of, known) for key, of in keys.items()},
        known,
        packages,
        complete=entry.get("complete", True),
        names=tuple(entry.get("names", ())),
        signs=tuple(entry.get("signs", ())),
        strips_slash=entry.get("strips_slash", False),
        odometry=port.topic if port else "",
        transform=entry.get("transform", {}),
    )


def _key(name: str, entry: Mapping[str, Any], distribution: str) -> Key:
    values = {**entry, **entry.get(HUMBLE, {})} if distribution == HUMBLE else entry
    default = values.get("default")
    if values["type"] == "double" and isinstance(default, str):
        default = float(default)
    return Key(
        name,
        values["type"],
        default,
        values.get("valid") or {},
        only=tuple(values.get("only", DISTRIBUTIONS)),
        frame=values.get("frame", ""),
        forced=values.get("forced", ""),
        needed=bool(values.get("needed")),
        stock=tuple(values.get("stock", ())),
        renamed=values.get("renamed", {}),
    )


def by_signs(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the kind that has most of its signs among some keys, or None if none has any."""
    best = max(kinds(distribution).values(), key=lambda kind: sum(sign in keys for sign in kind.signs))
    return best if any(sign in keys for sign in best.signs) else None


def controller_by_keys(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the controller of a drive that knows most of some keys, where they are those of one."""
    if "enable_odom_tf" not in keys:
        return None
    found = [kind for plugin in drive_plugins() if (kind := controller(plugin, distribution)) is not None]
    return max(found, key=lambda kind: sum(kind.key(name) is not None for name in keys))


def by_name(name: str, distribution: str) -> Kind | None:
    """Return the kind that a node of a name usually is."""
    return next((kind for kind in kinds(distribution).values() if name in kind.names), None)
