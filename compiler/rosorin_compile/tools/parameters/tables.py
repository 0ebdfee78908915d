"""What is known of nodes: their keys, types and defaults, as ``ros2_nodes.json`` and ``ros2_controllers.json`` have it.

The ``about`` of each file says what its fields mean, and where its facts are from.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from ...project import data_folder

HUMBLE, JAZZY = "humble", "jazzy"
DISTRIBUTIONS = (HUMBLE, JAZZY)
# Keys that every node has, and those below which any name may stand.
ANY_NODE = ("use_sim_time", "start_type_description_service")
ANY_BELOW = ("qos_overrides.", "diagnostic_updater.", "bond_heartbeat_period", "service_introspection_mode")
_VARIABLE = re.compile(r"(__map_\w+|<[a-z]+>)")


@dataclass(frozen=True)
class Key:
    """A parameter that a kind of node has. ``name`` may have pieces such as <n>, which stand for many names."""

    name: str
    type: str
    default: Any = None
    frame: str = ""
    lengths: tuple[int, ...] = ()
    one_of: tuple[str, ...] = ()
    only: tuple[str, ...] = DISTRIBUTIONS

    @property
    def many(self) -> bool:
        """Whether it stands for keys of many names."""
        return _VARIABLE.search(self.name) is not None

    def matches(self, name: str) -> bool:
        """Say whether a parameter is one of those that the key stands for."""
        return name == self.name or (self.many and re.fullmatch(_pattern(self.name), name) is not None)


@cache
def _pattern(name: str) -> str:
    pieces = _VARIABLE.split(name)
    return "".join(
        (r"\d+" if piece == "<n>" else r"[^.]+") if odd % 2 else re.escape(piece) for odd, piece in enumerate(pieces)
    )


@dataclass(frozen=True)
class Kind:
    """A kind of node. ``complete`` says that it has no keys but these.

    ``transform`` names the keys of the parent, the child and the switch of the transform that it publishes, and
    ``odometry`` is the topic that a controller publishes it on.
    """

    name: str
    packages: tuple[str, ...]
    keys: Mapping[str, Key]
    complete: bool = False
    names: tuple[str, ...] = ()
    signs: tuple[str, ...] = ()
    strips_slash: bool = False
    controller: bool = False
    odometry: str = ""
    transform: Mapping[str, str] = field(default_factory=dict)

    def key(self, name: str) -> Key | None:
        """Return what is known of a parameter; of several keys that fit the one without variables."""
        return self.keys.get(name) or next((key for key in self.keys.values() if key.many and key.matches(name)), None)


@cache
def _data(name: str) -> Any:
    return json.loads((data_folder("schemas") / f"{name}.json").read_text("utf-8"))


@cache
def kinds(distribution: str) -> Mapping[str, Kind]:
    """Return the kinds of nodes beside controllers, by name."""
    return {name: _kind(name, entry, distribution) for name, entry in _data("ros2_nodes")["nodes"].items()}


def _kind(name: str, entry: Mapping[str, Any], distribution: str) -> Kind:
    keys = {key: _key(key, of, distribution) for key, of in entry["keys"].items()}
    return Kind(
        name,
        (entry["package"],),
        keys,
        entry["complete"],
        tuple(entry["names"]),
        tuple(entry["signs"]),
        entry.get("strips_slash", False),
        transform=entry.get("transform", {}),
    )


def _key(name: str, entry: Mapping[str, Any], distribution: str) -> Key:
    lengths = entry.get("length", ())
    if isinstance(lengths, dict):
        lengths = lengths.get(distribution) or sorted({one for some in lengths.values() for one in some})
    only = tuple(entry.get("only", DISTRIBUTIONS))
    one_of = tuple(entry.get("one_of", ()))
    return Key(name, entry["type"], entry.get("default"), entry.get("frame", ""), tuple(lengths), one_of, only)


def controller(plugin: str, distribution: str) -> Kind | None:
    """Return what is known of a type of controller; None for one without a table.

    Without a distribution it has the keys of all of them.
    """
    tables = {one: _data("ros2_controllers")[one] for one in DISTRIBUTIONS}
    having = [one for one in DISTRIBUTIONS if plugin in tables[one] and plugin in tables[one]["plugins"]]
    chosen = [one for one in having if one == distribution] or having
    if not chosen:
        return None
    found: dict[str, Key] = {}
    for one in (*having, *chosen):  # the types and defaults of the chosen one win
        for name, entry in (tables[one]["every_controller"] | tables[one][plugin]).items():
            only = tuple(other for other in having if name in tables[other]["every_controller"] | tables[other][plugin])
            frame = _controller_frame(plugin, name)
            found[name] = Key(name, entry["type"], entry.get("default"), frame, _lengths(entry), (), only)
    package = tables[chosen[0]]["plugins"][plugin]
    odometry = _data("ros2_nodes")["controllers"]["odometry"].get(plugin, "")
    # update_rate is of every controller; so is the type, which may stand at the controller itself.
    found.setdefault("type", Key("type", "string"))
    packages = (package, *_OF_CONTROLLERS)
    transform = _ODOMETRY if odometry else {}
    return Kind(plugin, packages, found, complete=True, controller=True, odometry=odometry, transform=transform)


# The packages that a description may name for a controller: that which starts it is as good as its own.
_OF_CONTROLLERS = ("ros2_controllers", "ros2_control", "controller_manager")


_ODOMETRY = {"parent": "odom_frame_id", "child": "base_frame_id", "switch": "enable_odom_tf"}


def _controller_frame(plugin: str, key: str) -> str:
    by_type = _data("ros2_nodes")["controllers"]["frame_ids"].get(plugin, "")
    return "sensor" if key == by_type else {"odom_frame_id": "odom", "base_frame_id": "base"}.get(key, "")


def _lengths(entry: Mapping[str, Any]) -> tuple[int, ...]:
    fixed = entry.get("valid", {}).get("fixed_size")
    return tuple(fixed) if fixed else ()


def controller_types() -> set[str]:
    """Return every type of controller that is known by name, with a table or without."""
    return {plugin for one in DISTRIBUTIONS for plugin in _data("ros2_controllers")[one]["plugins"]}


def by_signs(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the kind that has most of its signs among some keys; None if none has any."""

    def count(kind: Kind) -> int:
        return sum(sign in keys for sign in kind.signs)

    best = max(kinds(distribution).values(), key=count)
    return best if count(best) else None


def controller_by_keys(keys: Mapping[str, object], distribution: str) -> Kind | None:
    """Return the controller of a drive that knows most of some keys, where they are those of one."""
    if _ODOMETRY["switch"] not in keys:
        return None
    drives = _data("ros2_nodes")["controllers"]["odometry"]
    known = [kind for plugin in drives if (kind := controller(plugin, distribution)) is not None]
    return max(known, key=lambda kind: sum(kind.key(name) is not None for name in keys))


def by_name(name: str, distribution: str) -> Kind | None:
    """Return the kind that a node of a name usually is."""
    return next((kind for kind in kinds(distribution).values() if name in kind.names), None)


def every(kind: Kind, distribution: str) -> Iterator[Key]:
    """Yield the keys of a kind that a distribution knows; without one, all."""
    return (key for key in kind.keys.values() if not distribution or distribution in key.only)
