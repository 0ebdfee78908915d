"""Turn the values that differ between the instances of a part into a few parameters.

Numbers that differ only in sign share a sign parameter. A text that contains the name of its use becomes an expression
with ``${name}``. A list or a small table in which most values differ is one parameter, and equal or opposite values in
several places share one.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity

from ..description import free_name, identifier
from ..layout import ROTATING, Expression, escaped, in_degrees
from .nodes import negative

_TABLES = ("limit", "dynamics", "inertial", "inertia", "safety_controller", "calibration", "box", "cylinder")
_MIN_IN_TABLE = 3  # differing values of a table that becomes one parameter
_TYPES = {
    **dict.fromkeys(("xyz", "size", "radius", "length", "min", "max", "radii"), "length"),
    **dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "inertia"),
    "rpy": "angle",
    "mass": "mass",
}
_ROTATING = {"lower": "angle", "upper": "angle", "effort": "torque", "velocity": "angular_speed"}
_SLIDING = {"lower": "length", "upper": "length", "effort": "force", "velocity": "speed"}
_DEGREES = {"angle": "deg", "angular_speed": "deg/s"}
_WORDS = {"lower": "lower_limit", "upper": "upper_limit", "file": "mesh", "rgba": "colour", "material": "look"}
_AXES = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}
RESERVED = ("name", "mirrored", "prefix", "first", "meshes")

Write = Callable[[str], str]  # the text of an expression, by the name of a parameter


@dataclass
class Parameter:
    """A parameter of a part: its type, its value in each instance, and the word that names it.

    A sign is 1 or -1; one that ``is_derived`` is computed by the part from ``mirrored``. ``places`` are the values that
    it replaces: the terms of a node, the path, and the expression.
    """

    kind: str
    values: Sequence[Any]
    word: str
    owner: str = ""
    is_derived: bool = False
    places: list[tuple[dict[Path, Any], Path, Write]] = field(default_factory=list)

    @property
    def default(self) -> Any:
        """The value of at least half of the instances, or None."""
        text, count = Counter(map(repr, self.values)).most_common(1)[0]
        has_default = self.kind != "sign" and count > 1 and 2 * count >= len(self.values)
        return next(value for value in self.values if repr(value) == text) if has_default else None


class Parameters:
    """The parameters of one part.

    ``uses``, ``prefixes`` and ``mirrored`` have the name of the use, the prefix of its names and whether it is
    mirrored, for each instance.
    """

    def __init__(self, uses: Sequence[str], prefixes: Sequence[str], mirrored: Sequence[bool]) -> None:
        self.uses, self.prefixes, self.mirrored = uses, prefixes, mirrored
        self.count = 0  # of values that became expressions
        self._index: dict[Any, Parameter] = {}

    def named(self) -> dict[str, Parameter]:
        """Return the parameters by name; the expressions that use them are written."""
        every = list(self._index.values())
        counts = Counter(one.word for one in every)
        named: dict[str, Parameter] = {}
        for one in every:
            word = one.word if counts[one.word] == 1 or not one.owner else f"{one.owner}_{one.word}"
            name = free_name(identifier(word), named)
            named[name] = one
            for terms, path, write in one.places:
                terms[path] = Expression(write(name))
        return named

    @property
    def given(self) -> int:
        """The number of parameters that a use gives."""
        return sum(not one.is_derived for one in self._index.values())

    def replace(self, values: Mapping[Path, Sequence[Any]], terms: dict[Path, Any], owner: str, kind: str) -> None:
        """Put an expression into ``terms`` for each value that differs between instances.

        ``owner`` names the link or joint, ``kind`` is the type of the joint.
        """
        differing = [path for path, some in values.items() if any(value != some[0] for value in some[1:])]
        counts = Counter(
            path[:length] for path in differing if not _is_sign(values[path]) for length in range(1, len(path))
        )
        units = dict.fromkeys(_unit(path, counts, is_number(values[path][0])) for path in differing)
        self.count += len(units)
        for unit in units:
            quantity = _type_of(unit, kind)
            if unit not in values:
                items = [
                    {path[len(unit) :]: some[index] for path, some in values.items() if path[: len(unit)] == unit}
                    for index in range(len(self.uses))
                ]
                is_list = isinstance(next(iter(items[0]))[0], int)
                table = [_in_degrees(_nested(item), quantity) for item in items]
                self._add("list" if is_list else "table", table, terms, unit, owner)
            elif all(map(is_number, values[unit])):
                self._add_number(values[unit], terms, unit, owner, quantity)
            elif all(isinstance(value, str) for value in values[unit]):
                self._add_text(values[unit], terms, unit, owner)
            else:
                is_flag = all(isinstance(value, bool) for value in values[unit])
                self._add("boolean" if is_flag else "any", values[unit], terms, unit, owner)

    def count_up(self, first: Sequence[int]) -> None:
        """Add the parameter ``first``: the first number in the names of each instance."""
        self._index["first"] = Parameter("integer", first, "first")

    def _add(
        self,
        kind: str,
        values: Sequence[Any],
        terms: dict[Path, Any],
        path: Path,
        owner: str,
        write: Write = lambda name: f"${{{name}}}",
    ) -> None:
        key = (kind if kind in ("text", "boolean", "any", "list", "table") else "number", repr(list(values)))
        if key not in self._index:
            words = [step for step in path if isinstance(step, str)]
            word = _WORDS.get(words[-1], words[-1])
            if isinstance(path[-1], int) and words[-1] in _AXES:
                word = _AXES[words[-1]][path[-1]]
            self._index[key] = Parameter(kind, values, word, re.sub(r"\$\{[^}]*\}", "", owner))
        self._index[key].places.append((terms, path, write))

    def _add_number(self, values: Sequence[Any], terms: dict[Path, Any], path: Path, owner: str, kind: str) -> None:
        if _is_sign(values):
            signs = tuple(1 if value == values[0] else -1 for value in values)
            is_derived = any(self.mirrored) and signs == tuple(-1 if flag else 1 for flag in self.mirrored)
            new = Parameter("sign", signs, "side" if is_derived else "direction", "", is_derived)
            sign = self._index.setdefault(signs, new)
            text = _spelt(values[0], _DEGREES.get(kind, ""))
            factor = text[:-1] if text in ("1", "-1") else f"{text} * "
            sign.places.append((terms, path, lambda name: f"${{{factor}{name}}}"))
            return
        shown = [_in_degrees(value, kind) for value in values]
        opposite = self._index.get(("number", repr([negative(value) for value in shown])))
        if opposite is not None:
            opposite.places.append((terms, path, lambda name: f"${{-{name}}}"))
            return
        has_unit = any(isinstance(value, Quantity) and value.text for value in values)
        self._add("any" if has_unit else kind, shown, terms, path, owner)

    def _add_text(self, texts: Sequence[str], terms: dict[Path, Any], path: Path, owner: str) -> None:
        if all(self.uses) and not any("${" in text or "$(" in text for text in texts):
            for word, names in (("name", self.uses), ("prefix", self.prefixes)):
                around = r"{}" if word == "prefix" else r"(?<![A-Za-z0-9]){}(?![A-Za-z0-9])"
                rows = {
                    tuple(re.split(around.format(re.escape(name)), text)) if name else ()
                    for text, name in zip(texts, names, strict=True)
                }
                if len(rows) == 1 and len(pieces := rows.pop()) > 1:
                    terms[path] = Expression(f"${{{word}}}".join(map(escaped, pieces)))
                    return
        before = after = ""
        if path[-1] == "file":  # the parameter is what differs between folder and ending
            folders, endings = ({text.rpartition(sign)[i] for text in texts} for sign, i in (("/", 0), (".", 2)))
            before = f"{min(folders)}/" if len(folders) == 1 and all("/" in text for text in texts) else ""
            after = f".{min(endings)}" if len(endings) == 1 and all("." in t[len(before) :] for t in texts) else ""
        inner = [text[len(before) : len(text) - len(after)] for text in texts]
        self._add("text", inner, terms, path, owner, lambda name: f"{escaped(before)}${{{name}}}{escaped(after)}")


def _unit(path: Path, counts: Mapping[Path, int], is_numeric: bool) -> Path:
    """Return the outermost table or list that becomes one parameter with a value, or the path of the value."""
    for length in range(1, len(path)):
        unit = path[:length]
        is_point = length == len(path) - 1 and isinstance(path[-1], int) and is_numeric
        if counts.get(unit, 0) >= (2 if is_point else _MIN_IN_TABLE) and (is_point or unit[-1] in _TABLES):
            return unit
    return path


def is_number(value: Any) -> bool:
    """Return True for an int or float, and False for a boolean."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _is_sign(values: Sequence[Any]) -> bool:
    return all(map(is_number, values)) and len({abs(value) for value in values}) == 1


def _type_of(path: Path, kind: str) -> str:
    """Return the type of a parameter for the value at a path."""
    keys = [key for key in path if isinstance(key, str)]
    if len(keys) > 2 and keys[:2] in (["joint", "limit"], ["joint", "safety_controller"]):
        return (_ROTATING if kind in ROTATING else _SLIDING).get(keys[-1], "number")
    return _TYPES.get(keys[-1], "number")


def _nested(items: Mapping[Path, Any]) -> Any:
    """Return the list or mapping with these values by path."""
    groups: dict[Any, dict[Path, Any]] = {}
    for path, value in items.items():
        groups.setdefault(path[0], {})[path[1:]] = value
    made = {key: rest[()] if () in rest else _nested(rest) for key, rest in groups.items()}
    return list(made.values()) if all(isinstance(key, int) for key in made) else made


def _in_degrees(value: Any, kind: str) -> Any:
    """Return angles as quantities in degrees where those are short and exact."""
    if isinstance(value, list):
        return [_in_degrees(item, kind) for item in value]
    unit = _DEGREES.get(kind, "")
    text = in_degrees(value, unit) if unit and is_number(value) and value else ""
    return Quantity.parse(text) if text else value


def _spelt(value: float, unit: str) -> str:
    if isinstance(value, Quantity) and value.text:
        return value.text
    return (unit and in_degrees(value, unit)) or exact(value)
