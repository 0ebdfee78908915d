"""Hardware blocks of ros2_control: their section of a description as a value of the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from rosorin_compile.language.lower.entries import Problem, entries_of
from rosorin_compile.language.lower.plainly import plain, record_of
from rosorin_compile.model.control import SENSOR_WORDS, SYSTEM, Block, Component, End, Interface, Transmission

if TYPE_CHECKING:
    Made = TypeVar("Made")


def control_of(tree: Mapping[str, Any], _: Problem) -> tuple[Block, ...]:
    """Return the hardware blocks of a description; a sensor without interfaces has those of its type."""
    types = {name: entry.get("type", "") for name, entry in (tree.get("sensors") or {}).items()}
    return tuple(_block(name, entry, types) for name, entry in entries_of(tree, "control"))


def _block(name: str, entry: Mapping[str, Any], types: Mapping[str, str]) -> Block:
    def sensor(called: str, said: Mapping[str, Any]) -> Component:
        made = _component(called, said)
        words = SENSOR_WORDS.get(types.get(called, ""), ()) if "state" not in said else ()
        return Component(called, made.command, tuple(map(Interface, words)), made.params) if words else made

    return record_of(
        Block,
        entry,
        name=name,
        type=entry.get("type", SYSTEM),
        params=_words(entry),
        joints=_each(entry, "joints", _component),
        sensors=_each(entry, "sensors", sensor),
        gpio=_each(entry, "gpio", _component),
        transmissions=_each(entry, "transmissions", _transmission),
        is_async=entry.get("async"),
    )


def _each(entry: Mapping[str, Any], key: str, make: Callable[[str, Mapping[str, Any]], Made]) -> tuple[Made, ...]:
    return tuple(make(name, one or {}) for name, one in (entry.get(key) or {}).items())


def _component(name: str, entry: Mapping[str, Any]) -> Component:
    command, state = (_interfaces(entry.get(key)) for key in ("command", "state"))
    return record_of(Component, entry, name=name, command=command, state=state, params=_words(entry))


def _interfaces(said: Any) -> tuple[Interface, ...]:
    if said is None:
        return ()
    if isinstance(said, Mapping):
        return tuple(_interface(name, one or {}) for name, one in said.items())
    return tuple(Interface(str(name)) for name in ([said] if isinstance(said, str) else said))


def _interface(name: str, entry: Mapping[str, Any]) -> Interface:
    low, high = (float(entry[key]) if key in entry else None for key in ("min", "max"))
    return record_of(Interface, entry, name=name, low=low, high=high, params=_words(entry))


def _transmission(name: str, entry: Mapping[str, Any]) -> Transmission:
    ends = {key: _each(entry, key, _end) for key in ("joints", "actuators")}
    return record_of(Transmission, entry, name=name, **ends)


def _end(name: str, entry: Mapping[str, Any]) -> End:
    return record_of(End, entry, name=name)


def _words(entry: Mapping[str, Any]) -> dict[str, str | float | bool]:
    return {key: plain(value) for key, value in (entry.get("params") or {}).items()}
