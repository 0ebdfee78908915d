"""Blocks: what calls hand over as elements, as parameters of their own: an origin as ``xyz`` and ``rpy``.

So a call that says what the macro does not take is refused, and expressions, which have no tables, can hand it over.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from .pieces import Entry, Given, Handed, Item, Listed, Macro
from .scopes import LIST, LISTS, NUMBERS, TABLE, Scope, Value, Variable

# What a call may leave out: it is the default of the language then.
OPTIONAL = ("xyz", "rpy", "scale")
# Where an origin may stand; it is read in the same way.
ORIGIN_LEVELS = frozenset(("inertial", "solid", "joint", "origin"))
MAX_LEAVES = 6

Path = tuple[str, ...]
_ORIGIN: dict[Path, tuple[str, bool]] = {("xyz",): ("length3", False), ("rpy",): ("angle3", False)}


class Leaf(NamedTuple):
    """A parameter that is one value of a block: where it stands in it, its name, and whether all calls give it."""

    path: Path
    name: str
    sink: str
    always: bool


def owner(scope: Scope) -> Macro | None:
    """Return the macro that a scope belongs to."""
    here: Scope | None = scope
    while here is not None:
        macro = getattr(here, "macro", None)
        if isinstance(macro, Macro):
            return macro
        here = here.parent
    return None


def leaves(macro: Macro, block: str, program: Scope) -> list[Leaf] | None:
    """Return the parameters that stand for a block; None where it has to stay a table."""
    sinks = _taken_apart(macro, block)
    if sinks is None:
        return None
    names = _names(macro, block, list(sinks), program)
    return [Leaf(path, name, *sinks[path]) for path, name in zip(sinks, names, strict=True)]


def inserted(macro: Macro) -> list[str]:
    """Return the blocks of a macro that it inserts somewhere, in the order of its parameters."""
    return [one.name for one in macro.parameters if one.block and one.name in macro.block_levels]


def value_at(entry: Entry, path: Path) -> Value | Handed | Entry | Given | list[Listed] | None:
    """Return what an entry of a block says at a path: itself, or by a block that is handed on."""
    for item in entry.items:
        if item.key == "&":
            return item.value  # type: ignore[no-any-return]
        if item.key == path[0]:
            return value_at(item.value, path[1:]) if len(path) > 1 else item.value
    return None


def _taken_apart(macro: Macro, block: str) -> dict[Path, tuple[str, bool]] | None:
    """Return the values that stand for a block: each of them, or for a part what stands under its keys."""
    found = _sinks(macro, block)
    given = macro.blocks_given.get(block)
    return _whole(given) if found is None and given and macro.body is not None else found


def _sinks(macro: Macro, block: str, depth: int = 0) -> dict[Path, tuple[str, bool]] | None:
    """Return what all calls give of a block: by its path its sink, and whether each call gives it."""
    every: list[dict[Path, tuple[str, bool]]] = []
    for entry in macro.blocks_given.get(block, ()):
        found = dict(_values(entry.items, depth))
        if not all(found.values()) or len(found) < sum(1 for _ in _values(entry.items, depth)):
            return None
        every.append(found)  # type: ignore[arg-type]
    made: dict[Path, tuple[str, bool]] = {}
    for path in dict.fromkeys(path for found in every for path in found):
        (sink, _), *others = [found[path] for found in every if path in found]
        always = len(others) + 1 == len(every) and all(found[path][1] for found in every)
        if (not always and path[-1] not in OPTIONAL) or any(one[0] != sink for one in others):
            return None
        made[path] = (sink, always)
    if macro.block_levels.get(block) in ORIGIN_LEVELS and made.keys() <= _ORIGIN.keys():
        made = dict(_ORIGIN)  # whatever the calls say of it: who writes another one may turn it
    return made if len({path[-1] for path in made}) == len(made) <= MAX_LEAVES else None


def _whole(entries: list[Entry]) -> dict[Path, tuple[str, bool]] | None:
    """Return the keys that all calls give of a block; None where they give different ones, or on conditions."""
    keys = [item.key for item in entries[0].items]
    for entry in entries:
        if [item.key for item in entry.items] != keys or any(item.when for item in entry.items):
            return None
        if not all(isinstance(item.value, (Entry, Given, list)) for item in entry.items):
            return None
    sinks = [LIST if isinstance(item.value, list) else TABLE for item in entries[0].items]
    made: dict[Path, tuple[str, bool]] = {(key,): (sink, True) for key, sink in zip(keys, sinks, strict=True)}
    return made if len(made) == len(keys) else None


def _values(items: list[Item], depth: int) -> Iterator[tuple[Path, tuple[str, bool] | None]]:
    """Yield the values of a block with their sinks; None for what is no plain value."""
    for item in items:
        if item.key == "&" and not item.when and depth < 20 and isinstance(item.value, Handed):
            outer = owner(item.value.scope)
            found = _sinks(outer, item.value.parameter.name, depth + 1) if outer is not None else None
            yield from found.items() if found is not None else [((item.key,), None)]
        elif isinstance(item.value, Entry) and not item.when:
            yield from (((item.key, *path), sink) for path, sink in _values(item.value.items, depth))
        else:
            plain = isinstance(item.value, Value) and not item.when and item.value.sink in _TYPES
            yield (item.key,), (item.value.sink, True) if plain else None


def _names(macro: Macro, block: str, paths: list[Path], program: Scope) -> list[str]:
    """Return the names of the parameters: the words themselves; with that of the block where one of them is taken."""
    from .expressions import usable

    variables = [*macro.variables.values(), *macro.implicit.values(), *(macro.body.locals if macro.body else ())]
    taken = {one.ours for one in (*variables, *program.names.values()) if isinstance(one, Variable)}
    others = {path[-1] for other in inserted(macro) if other != block for path in _taken_apart(macro, other) or ()}
    words = [path[-1] for path in paths]
    if any(word in taken or word in others for word in words):
        words = [f"{block}_{word}" for word in words]
    return [usable(word, lambda one: one in taken) for word in words]


_TYPES = {
    **dict.fromkeys(LISTS, "list"),
    **{one: one for one in NUMBERS},
    "speed": "",
    "file": "text",
    "name": "text",
    TABLE: TABLE,
    LIST: LIST,
}


def type_of(leaf: Leaf) -> str:
    """Return the type of a parameter; empty where anything may come."""
    return _TYPES[leaf.sink]
