"""Turn the values that differ between the instances of a part into a few parameters.

Numbers that differ only in sign share a sign parameter. A text that contains the name of its use becomes an expression
with ``${name}``. A list or a small table in which most values differ is one parameter, and equal or opposite values in
several places share one.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity

from ..description import free_name, identifier
from ..layout import ROTATING, Expression, escaped, in_degrees
from .nodes import Values, is_number, negative
from .part_names import sign_name

MAX_PARAMETERS = 6
GIVEN = "with"
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
_HINTS = {"lower": "lower_limit", "upper": "upper_limit", "file": "mesh", "rgba": "colour", "material": "look"}
_AXES = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}
RESERVED = ("name", "mirrored", "prefix", "first", "meshes")


class Parameter:
    """A parameter of a part: its type, its value in each instance, and candidates for its name, the best one first.

    A sign is 1 or -1; one that ``is_derived`` is computed by the part from ``mirrored``.
    """

    def __init__(self, kind: str, values: Sequence[Any], hints: Sequence[str], is_derived: bool = False) -> None:
        self.kind, self.values, self.hints, self.is_derived = kind, values, hints, is_derived
        self.name = ""

    @property
    def default(self) -> Any:
        """The value of at least half of the instances, or None."""
        counts = Counter(map(repr, self.values))
        text, count = counts.most_common(1)[0]
        has_default = self.kind != "sign" and count > 1 and 2 * count >= len(self.values)
        return next(value for value in self.values if repr(value) == text) if has_default else None


class Parameters:
    """The parameters of one part.

    ``uses``, ``prefixes`` and ``mirrored`` have the name of the use, the prefix before names and whether the use is
    mirrored, for each instance.
    """

    def __init__(self, uses: Sequence[str], prefixes: Sequence[str], mirrored: Sequence[bool]) -> None:
        self.uses, self.prefixes, self.mirrored = uses, prefixes, mirrored
        self.all: list[Parameter] = []
        self.count = 0  # of values that became expressions
        self._pending: list[tuple[dict[Path, Any], Path, str, list[Parameter], str]] = []
        self._index: dict[Any, Parameter] = {}
        self._signs: dict[tuple[int, ...], Parameter] = {}

    @property
    def given(self) -> list[Parameter]:
        """The parameters that a use gives."""
        return [one for one in self.all if not one.is_derived]

    def replace(self, values: Values, terms: dict[Path, Any], owner: str, kind: str, types: Mapping[str, str]) -> None:
        """Put an expression into ``terms`` for each value that differs.

        ``owner`` names the link, joint or use, ``kind`` is the type of the joint; ``types`` are those of the parameters
        that a use gives.
        """
        differing = [path for path, some in values.items() if any(value != some[0] for value in some[1:])]
        counts = Counter(
            path[:length] for path in differing if not _is_sign(values[path]) for length in range(1, len(path))
        )
        whole: dict[Path, list[Path]] = {}
        for path in differing:
            whole.setdefault(_changed_unit(path, values, counts), []).append(path)
        self.count += len(whole)
        for unit, paths in whole.items():
            name = _type_of(unit, kind, types)
            if unit != paths[0]:
                items = [
                    {path[len(unit) :]: some[i] for path, some in values.items() if path[: len(unit)] == unit}
                    for i in range(len(self.uses))
                ]
                table = "list" if isinstance(next(iter(items[0]))[0], int) else "table"
                parameter = self._known(table, [_in_degrees(_nested(item), name) for item in items], unit, owner)
                self._pending.append((terms, unit, "{}", [parameter], ""))
            else:
                self._replace_scalar(values[unit], terms, unit, owner, name)

    def _replace_scalar(
        self, values: tuple[Any, ...], terms: dict[Path, Any], path: Path, owner: str, kind: str
    ) -> None:
        if all(map(is_number, values)):
            if _is_sign(values):
                signs = tuple(1 if value == values[0] else -1 for value in values)
                number = _spelt(values[0], _DEGREES.get(kind, ""))
                self._pending.append((terms, path, "{}", self._factors(signs), number))
                return
            opposite = self._index.get(("number", repr([negative(value) for value in values])))
            if opposite is not None:
                self._pending.append((terms, path, "{}", [opposite], "-1"))
                return
            has_unit = any(isinstance(value, Quantity) and value.text for value in values)
            shown = [_in_degrees(value, kind) for value in values]
            parameter = self._known("any" if has_unit else kind, shown, path, owner, ("number", repr(list(values))))
            self._pending.append((terms, path, "{}", [parameter], ""))
        elif all(isinstance(value, str) for value in values):
            self._replace_text(values, terms, path, owner)
        else:
            kind = "boolean" if all(isinstance(value, bool) for value in values) else "any"
            self._pending.append((terms, path, "{}", [self._known(kind, values, path, owner)], ""))

    def _replace_text(self, texts: Sequence[str], terms: dict[Path, Any], path: Path, owner: str) -> None:
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
        parameter = self._known("text", inner, path, owner)
        shape = "{{}}".join(text.replace("{", "{{").replace("}", "}}") for text in (escaped(before), escaped(after)))
        self._pending.append((terms, path, shape.replace("{{}}", "{}"), [parameter], ""))

    def _factors(self, signs: tuple[int, ...]) -> list[Parameter]:
        """Return the sign parameters whose product these signs are, at most two, or a new one."""
        if signs in self._signs:
            return [self._signs[signs]]
        for one, first in self._signs.items():
            for other, second in self._signs.items():
                if one < other and tuple(a * b for a, b in zip(one, other, strict=True)) == signs:
                    return [first, second]
        is_derived = any(self.mirrored) and signs == tuple(-1 if flag else 1 for flag in self.mirrored)
        hint = sign_name(self.uses, signs) or ("side" if is_derived else "direction")
        self._signs[signs] = Parameter("sign", signs, [hint], is_derived)
        self.all.append(self._signs[signs])
        return [self._signs[signs]]

    def _known(self, kind: str, values: Sequence[Any], path: Path, owner: str, key: Any = None) -> Parameter:
        key = key or (kind, repr(list(values)))
        if key not in self._index:
            steps = [step for step in path if isinstance(step, str)]
            word = _HINTS.get(steps[-1], steps[-1])
            if isinstance(path[-1], int) and steps[-1] in _AXES:
                word = _AXES[steps[-1]][path[-1]]
            plain = re.sub(r"\$\{[^}]*\}", "", owner)
            self._index[key] = Parameter(kind, values, [word, f"{plain}_{word}"])
            self.all.append(self._index[key])
        return self._index[key]

    def name_all(self) -> None:
        """Name the parameters, and write the expressions that use them."""
        count = Counter(one.hints[0] for one in self.all)
        taken: set[str] = set()
        for one in self.all:
            one.name = one.name or free_name(
                identifier(one.hints[-1] if count[one.hints[0]] > 1 else one.hints[0]), taken
            )
            taken.add(one.name)
        for terms, path, shape, factors, number in self._pending:
            names = [factor.name for factor in factors]
            if number in ("1", "-1"):
                names[0] = number[:-1] + names[0]
            elif number:
                names.insert(0, number)
            terms[path] = Expression(shape.format(f"${{{' * '.join(names)}}}"))


def differences(one: Values, other: Values) -> tuple[int, int]:
    """Count the numbers that differ between two nodes, and those that differ only in sign.

    Values that are likely to be one parameter count once: a list, a small table.
    """
    pairs = {path: (a[0], other[path][0]) for path, a in one.items() if is_number(a[0]) and a != other[path]}
    signs = [path for path in pairs if _is_sign((*one[path], *other[path]))]
    free = [path for path in pairs if path not in signs]
    counts = Counter(path[:length] for path in free for length in range(1, len(path)))
    return len({_changed_unit(path, one, counts) for path in free}), len(signs)


def _changed_unit(path: Path, values: Values, counts: Mapping[Path, int]) -> Path:
    """Return the outermost table or list that becomes one parameter together with this value, or the value's path."""
    for length in range(1, len(path)):
        unit = path[:length]
        is_point = length == len(path) - 1 and isinstance(path[-1], int) and is_number(values[path][0])
        is_table = unit[-1] in _TABLES or unit[:-1] == (GIVEN,)
        if counts.get(unit, 0) >= (2 if is_point else _MIN_IN_TABLE) and (is_point or is_table):
            return unit
    return path


def _is_sign(values: Sequence[Any]) -> bool:
    return all(map(is_number, values)) and len({abs(value) for value in values}) == 1


def _type_of(path: Path, kind: str, types: Mapping[str, str]) -> str:
    """Return the type of a parameter for the value at a path."""
    keys = [key for key in path if isinstance(key, str)]
    if keys[0] == GIVEN:
        return types.get(keys[1], "number") if len(keys) == 2 else "number"
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
