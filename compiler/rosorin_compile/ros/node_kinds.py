"""Load the kinds of ROS nodes (``ros2_nodes.json``, ``ros2_controllers.json``), and validate their parameters.

The key ``about`` of each file explains its fields and sources. Validators have the names of
``PickNikRobotics/generate_parameter_library``; ``set_of`` is added for the interface combinations of
joint_trajectory_controller (``validate_jtc_parameters.hpp`` of ros2_controllers).
"""

import difflib
import math
import operator
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from types import NoneType
from typing import Any, NamedTuple

from rosorin_compile.formats.format import HUMBLE, JAZZY
from rosorin_compile.model import Publisher
from rosorin_compile.model.joint import NODE
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Related, Span, Suggestion, diagnostic
from rosorin_compile.source.wording import phrase, quote, suggest

from .ports import Role, distribution_of_ports, facts, port_of

DISTRIBUTIONS = (HUMBLE, JAZZY, "kilted")  # distributions in the tables; "" means any
MANAGER = "controller_manager"
REMOVE = "remove the parameter"
_TYPES: Mapping[str, Any] = {"bool": bool, "int": int, "double": float, "string": str}
# Parameters that every node accepts, by name and by prefix.
_ANY_NODE = ("use_sim_time", "start_type_description_service")
_ANY_BELOW = ("qos_overrides.", "diagnostic_updater.", "bond_heartbeat_period", "service_introspection_mode")
_VARIABLE = re.compile(r"(__map_\w+|<[a-z]+>)")
_pieces = cache(_VARIABLE.split)


class Key(NamedTuple):
    """A parameter of a kind of node; variables in its name, such as <n> in ``odom<n>``, match any number or word.

    ``valid`` maps validators to their arguments. ``only`` are the distributions that have the parameter; for a plugin
    parameter, ``stock`` are those whose default plugin has it. ``frame`` is the role of a frame name, or "" for other
    values. ``forced`` is a value that cannot be changed. If ``needed``, the node will not start without the parameter.
    ``renamed`` maps values of earlier distributions to their replacements.
    """

    name: str
    type: str
    default: Any = None
    valid: Mapping[str, list[Any]] = {}
    only: Sequence[str] = DISTRIBUTIONS
    frame: str = ""
    forced: str = ""
    needed: bool = False
    stock: Sequence[str] = ()
    renamed: Mapping[str, str] = {}

    @property
    def many(self) -> bool:
        """Whether the name contains variables."""
        return "<" in self.name or "__map_" in self.name


@cache
def _pattern(name: str) -> re.Pattern[str]:
    pieces = [re.escape(piece) for piece in _pieces(name)]
    pieces[1::2] = [r"(\d+)" if piece == re.escape("<n>") else r"([^.]+)" for piece in pieces[1::2]]
    return re.compile("".join(pieces))


class Kind(NamedTuple):
    """A kind of node, such as amcl, or a type of controller; ``keys`` are its parameters by name.

    ``keys`` has the parameters of all distributions, with the defaults of ``distribution``; if ``complete``, there are
    no others. ``names`` are usual names of the node, ``signs`` are parameters that identify this kind. ``transform``
    names the parameters for "parent", "child" and "switch" of the published transform. ``odometry`` is the topic on
    which a controller publishes a transform, or "".
    """

    name: str
    keys: Mapping[str, Key]
    distribution: str = ""
    packages: tuple[str, ...] = ()
    complete: bool = True
    names: Sequence[str] = ()
    signs: Sequence[str] = ()
    strips_slash: bool = False
    odometry: str = ""
    transform: Mapping[str, str] = {}

    def key(self, name: str) -> Key | None:
        """Return the parameter with this name or with a pattern that matches the name, or None if there is none."""
        many = ((key, _pieces(key.name)) for key in self.keys.values() if key.many)
        likely = (key for key, pieces in many if name.startswith(pieces[0]) and name.endswith(pieces[-1]))
        return self.keys.get(name) or next((key for key in likely if _pattern(key.name).fullmatch(name)), None)

    def __contains__(self, name: object) -> bool:
        key = self.key(str(name))
        return key is not None and self.has(key)

    def has(self, key: Key) -> bool:
        return not self.distribution or self.distribution in key.only

    def writes(self, key: Key) -> bool:
        """Return True if the distribution has the parameter; a plugin parameter must belong to the default plugin."""
        return self.has(key) and (not key.stock or self.distribution in key.stock)

    def own_keys(self) -> Iterator[Key]:
        """Yield the parameters that exist in ``self.distribution``."""
        return filter(self.has, self.keys.values())

    def suggestions(self, name: str) -> set[str]:
        """Return parameter names to suggest for a misspelt name; its words are inserted for variables such as <n>."""
        words, number, found = name.split("."), next(iter(re.findall(r"\d+", name)), "0"), set()
        for pieces in (key.name.replace("<n>", number).split(".") for key in self.own_keys()):
            variables = [index for index, piece in enumerate(pieces) if _VARIABLE.fullmatch(piece)]
            if not variables or len(pieces) == len(words):
                found.add(".".join(words[at] if at in variables else piece for at, piece in enumerate(pieces)))
        return found


def is_of(name: str, kind: Kind | None, publisher: Publisher, publishers: Iterable[Publisher]) -> bool:
    """Return True if a node in a file is the node ``publisher`` of the description.

    The names must be equal. If no publisher has the name of the node, equal packages are sufficient.
    """
    of_package = kind is not None and publisher.package in kind.packages
    is_named = any(name == other.name for other in publishers)
    return publisher.kind == NODE and (name == publisher.name or (of_package and not is_named))


@cache
def kinds(distribution: str) -> Mapping[str, Kind]:
    """Return the kinds of nodes for a distribution by name, without controllers."""
    return {name: _kind(name, entry, {}, (), distribution) for name, entry in facts("ros2_nodes")["nodes"].items()}


@cache
def controller(plugin: str, distribution: str) -> Kind | None:
    """Return a controller type with its parameters, or None if they are unknown; ``distribution`` can be "" for any."""
    table = facts("ros2_controllers")
    entry = table["controllers"].get(plugin, {})
    if "keys" not in entry:
        return None
    return _kind(plugin, entry, table["every_controller"], ("ros2_controllers", "ros2_control", MANAGER), distribution)


def plugins(distribution: str) -> Mapping[str, str]:
    """Map the controller types of a distribution to their packages, including types with unknown parameters."""
    found, known = facts("ros2_controllers")["controllers"], distribution and distribution_of_ports(distribution)
    return {name: of["package"] for name, of in found.items() if not known or known in of.get("only", DISTRIBUTIONS)}


def _kind(name: str, entry: Mapping[str, Any], keys: Mapping[str, Any], packages: tuple[str, ...], distro: str) -> Kind:
    known, port = distro and distribution_of_ports(distro), port_of(name, "", Role.TF)
    known, made = known if known in entry.get("only", DISTRIBUTIONS) else "", {}
    for key, of in {**keys, **entry["keys"]}.items():
        values = {**of, **of.get(HUMBLE, {})} if known == HUMBLE else of
        fields = {field: value for field, value in values.items() if field in Key._fields and value is not None}
        if fields["type"] == "double" and isinstance(fields.get("default"), str):
            fields["default"] = float(fields["default"])  # JSON has no NaN, so the table has a string
        made[key] = Key(key, **fields)
    words = {word: entry[word] for word in ("complete", "names", "signs", "strips_slash", "transform") if word in entry}
    return Kind(name, made, known, (entry["package"], *packages), odometry=port.topic if port else "", **words)


def by_signs(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Infer the kind of a node from its parameters ``keys``, or return None if they identify no kind."""
    best = max(kinds(distribution).values(), key=lambda kind: sum(sign in keys for sign in kind.signs))
    return best if any(sign in keys for sign in best.signs) else None


def drive_by_keys(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Infer the type of a drive controller from its parameters, or return None if ``enable_odom_tf`` is missing."""
    if "enable_odom_tf" not in keys:
        return None
    plugins = [name for name, about in facts("ros2_ports")["controllers"]["interfaces"].items() if "drive" in about]
    found = [kind for plugin in plugins if (kind := controller(plugin, distribution)) is not None]
    return max(found, key=lambda kind: sum(kind.key(name) is not None for name in keys))


def fits(value: Any, kind: str) -> bool:
    """Return True if rcl accepts a value for a parameter type. An integer is not a valid double.

    >>> fits(1, "double"), fits(1.0, "double"), fits([1, 2.0], "double_array"), fits("a", "string or string_array")
    (False, True, False, True)
    """
    if " or " in kind:
        return any(fits(value, one) for one in kind.split(" or "))
    if kind.endswith("_array"):
        return isinstance(value, (list, tuple)) and all(fits(each, kind.removesuffix("_array")) for each in value)
    return kind == "none" or (isinstance(value, _TYPES[kind]) and (kind == "bool" or not isinstance(value, bool)))


def convert(value: Any, kind: str) -> Any:
    """Convert numbers to a parameter type, such as 1 to 1.0 for a double; return other values unchanged."""
    for one in kind.split(" or "):
        if one.endswith("_array") and isinstance(value, (list, tuple)):
            return [convert(item, one.removesuffix("_array")) for item in value]
        if one == "double" and isinstance(value, (int, float)) and not isinstance(value, bool):
            return float(value)
        if one == "int" and isinstance(value, float) and value.is_integer():
            return int(value)
    return value


def as_yaml(value: Any) -> str:
    """Format a value as YAML on one line."""
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(as_yaml, value))}]"
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    return f'"{value}"' if isinstance(value, str) else repr(value)


_BOUNDS: Mapping[str, tuple[Callable[[Any, Any], bool], str]] = {  # (comparison, words for messages) by validator
    "gt": (operator.gt, "above"),
    "gt_eq": (operator.ge, "at least"),
    "lt_eq": (operator.le, "at most"),
    "fixed_size": (operator.eq, ""),
    "size_gt": (operator.gt, "more than "),
    "size_lt": (operator.lt, "fewer than "),
}


def _refused(name: str, value: Any, arguments: list[Any]) -> tuple[str, Help]:
    """Run the validator ``name`` on a value; return (reason, fix), where the reason is "" for a valid value."""
    compare, words = _BOUNDS.get(name.removesuffix("_or_nan"), (None, ""))
    if compare is not None and "size" in name:
        if not any(compare(len(value), size) for size in arguments):
            return f"has {len(value)} values, but needs {words}{' or '.join(map(str, arguments))}", ""
    elif compare is not None:
        if not (name.endswith("_or_nan") and math.isnan(value)) and not compare(value, arguments[0]):
            return f"is {as_yaml(value)}, but must be {words} {arguments[0]:g}", ""
    elif name in ("one_of", "subset_of"):
        if others := [str(one) for one in (value if name == "subset_of" else [value]) if one not in arguments[0]]:
            return f"cannot be {quote(others)}", Suggestion(others[0], [*map(str, arguments[0])])
    elif name == "not_empty" and not len(value):
        return "is empty", ""
    elif name == "unique" and (repeated := [str(one) for one in dict.fromkeys(value) if value.count(one) > 1]):
        return f"has {quote(repeated)} twice", "remove the duplicate"
    elif name == "set_of" and set(value) not in map(set, arguments):
        return f"is {as_yaml(value)}, but must be {' or '.join(map(as_yaml, arguments))}", ""
    return "", ""


class Finding(NamedTuple):
    """A problem with a node or a parameter; ``at_key`` is True if the name of the parameter is wrong, not the value.

    ``unknown`` is a misspelt name in the value, and ``known`` are names to suggest for it.
    """

    rule: str
    message: str
    key: str = ""
    help: Help = ""
    severity: str = ERROR
    at_key: bool = False
    unknown: str = ""
    known: Collection[str] = ()

    def place(self, span: Span | None, related: Iterable[Related] = ()) -> Diagnostic:
        """Convert the finding to a diagnostic at a position in a file."""
        return diagnostic(self.rule, self.severity, self.message, span, self.help, related)


def against_kind(name: str, kind: Kind | None, values: Mapping[str, Any]) -> Iterator[Finding]:
    """Validate the parameters of a node; ``values`` maps dotted names to values, ``name`` is the node in messages.

    If ``kind`` is None, only values that no parameter can have are reported.
    """
    for key, value in values.items():
        known = kind.key(key) if kind is not None else None
        if kind is None:
            types = set(map(type, value if isinstance(value, (list, tuple)) else [value]))
            if len(types) > 1 or types & {list, tuple, NoneType}:
                message = f'"{key}" of {name} is {as_yaml(value)}: no parameter can be that'
                yield Finding("parameters-wrong-type", message, key, "write a value, or a list of values of one type")
        elif known is None or not kind.has(known):
            if known is not None or not (key in _ANY_NODE or key.startswith(_ANY_BELOW)):
                yield from _unknown(name, kind, key, values, known)
        else:
            yield from _wrong_value(name, key, value, known)
            many = known.name.partition("__map_")[2].partition(".")[0]  # "joints" in gains.__map_joints.p
            match, listed = _pattern(known.name).fullmatch(key), values.get(many)
            if match and many and key not in kind.keys and isinstance(listed, (list, tuple)) and match[1] not in listed:
                message = f'"{key}" of {name} has no effect: "{match[1]}" is not in its {many}'
                help = Suggestion(match[1], set(map(str, listed)))
                yield Finding("parameters-unknown-key", message, key, help, at_key=True)


def _unknown(name: str, kind: Kind, key: str, values: Mapping[str, Any], of_others: Key | None) -> Iterator[Finding]:
    names, severity = kind.suggestions(key), ERROR
    close = difflib.get_close_matches(key, names - values.keys(), n=1, cutoff=0.9)
    help = Suggestion(key, names, instead=REMOVE) if kind.complete else suggest(close[0]) if close else ""
    if of_others is not None:
        others = phrase(map(str.capitalize, of_others.only))
        message = f'{name} of {kind.distribution.capitalize()} has no parameter "{key}", which exists only in {others}'
    elif below := [one.removeprefix(f"{key}.") for one in sorted(names) if one.startswith(f"{key}.")]:
        message, severity = f'"{key}" of {name} has no effect: it is a mapping', ERROR if kind.complete else WARNING
        help = f"write {key}: {{{', '.join(f'{one}: VALUE' for one in below)}}}"
    elif kind.complete:
        message = f'{name} has no parameter "{key}", and silently ignores it'
    elif help:
        message, severity = f'"{key}" of {name} is nearly a key that it has', WARNING
    else:
        return
    yield Finding("parameters-unknown-key", message, key, help or REMOVE, severity, at_key=True)


def _wrong_value(name: str, key: str, value: Any, known: Key) -> Iterator[Finding]:
    what, kind = f'"{key}" of {name}', known.type
    if not fits(value, kind):
        words = " or ".join(facts("ros2_nodes")["types"][one] for one in kind.split(" or "))
        made = [value] if kind == "string_array" else convert(value, kind)
        made = as_yaml(value) if kind == "string" and not isinstance(value, (list, tuple)) else made
        help = f"write {as_yaml(made) if fits(made, kind) else words}"
        help = f"write {words} without quotes" if isinstance(value, str) and kind in ("bool", "int", "double") else help
        message = f"{what} is {as_yaml(value)}, but must be {words}, or the node will not start"
        yield Finding("parameters-wrong-type", message, key, help)
    elif isinstance(value, str) and value in known.renamed:
        message = f'{what} is "{value}", which was renamed: the node will not start'
        yield Finding("parameters-wrong-value", message, key, f"write {known.renamed[value]}")
    elif known.forced and value not in ("", known.forced):
        message = f'{what} is always "{known.forced}", so this value has no effect'
        yield Finding("parameters-wrong-value", message, key, REMOVE, WARNING)
    else:
        found = (_refused(validator, value, list(arguments)) for validator, arguments in known.valid.items())
        why, fix = next((one for one in found if one[0]), ("", ""))
        if why:
            yield Finding("parameters-wrong-value", f"{what} {why}", key, fix or "correct the value")
