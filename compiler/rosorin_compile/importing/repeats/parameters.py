"""Parameters: what differs between the instances of a part becomes a few parameters of it.

Numbers that differ in their sign alone share a sign, ``side``; a text that holds the name of its instance holds
``${name}``; a list or a small table of which most differs is one parameter. The same value, or its negative, in several
places is one parameter. What all but a few instances have is the default.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from keyword import iskeyword
from typing import Any

from rosorin_compile.language.expression.functions import expression_names
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity

from ..layout import ROTATING, Expression, escaped, in_degrees
from .forms import Form, Leaf, Node, flat, leaves, sliced
from .names import side_word

MAX_PARAMETERS = 6
_TABLES = ("limit", "dynamics", "inertial", "inertia", "safety_controller", "calibration", "box", "cylinder")
GIVEN = "with"  # what a use gives its part
_SMALL = 6  # links, joints and their places; in a larger part parameters are called after what they belong to
_MANY = 3  # leaves of a table that differ, from which on it is given as a whole

_TYPES = {
    **dict.fromkeys(("xyz", "size", "radius", "length", "min", "max", "radii"), "length"),
    **dict.fromkeys(("rpy", "offset"), "angle"),
    **dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), "inertia"),
    "mass": "mass",
}
_TURNING = dict.fromkeys(("lower", "upper", "soft_lower_limit", "soft_upper_limit", "spring_reference"), "angle")
_TURNING |= {"effort": "torque", "velocity": "angular_speed"}
_SLIDING = dict.fromkeys(_TURNING, "length") | {"effort": "force", "velocity": "speed"}
_DEGREES = {"angle": "deg", "angular_speed": "deg/s"}
_CALLED = {"lower": "lower_limit", "upper": "upper_limit", "file": "mesh", "rgba": "colour", "material": "look"}
_TAKEN = ("name", "mirrored", "prefix", "mesh_scale", "meshes", "side", "end")
_AXES = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}
_AS_A_WORD = r"(?<![A-Za-z0-9]){}(?![A-Za-z0-9])"


class Parameter:
    """One parameter: its value in each instance as forms of one instance each, what it is, and how it is called.

    ``kind`` is a type of the language, ``sign`` for one that is 1 or -1. ``hint`` are words for its name, the best one
    first. ``own`` says that the part works it out by itself, from ``mirrored``.
    """

    def __init__(self, values: Form, kind: str, hint: Sequence[str], own: bool = False) -> None:
        self.values, self.kind, self.hint, self.own = values, kind, hint, own
        self.name = ""

    @cached_property
    def default(self) -> Form | None:
        """The value that at least half of the instances give, None without one."""
        if self.kind == "sign":
            return None
        rows = list(zip(*(leaf.values for leaf in flat(self.values)), strict=True))
        value, count = Counter(rows).most_common(1)[0]
        first = rows.index(value)
        return sliced(self.values, first, first + 1) if 2 * count >= len(rows) and count > 1 else None


class Term:
    """What stands in the place of a value: a parameter, its negative, a number with signs, or a text around it."""

    def __init__(self, factors: list[Parameter], number: str = "", before: str = "", after: str = "") -> None:
        self.factors, self.number = factors, number
        self.before, self.after = before, after

    def expression(self) -> Expression:
        """Return it as the language has it, once the parameters have names."""
        names = [factor.name for factor in self.factors]
        if self.number in ("1", "-1"):
            names[0] = ("-" if self.number == "-1" else "") + names[0]
        elif self.number:
            names.insert(0, self.number)
        return Expression(f"{self.before}${{{' * '.join(names)}}}{self.after}")


class Owner:
    """What has values: a link, a joint, or a use within a part, with the unit that its numbers have in degrees."""

    def __init__(
        self, name: str, entry: Form, turns: bool = False, kind: str = "", given: Mapping[str, str] | None = None
    ) -> None:
        self.name, self.entry, self.turns, self.kind = name, entry, turns, kind
        self.given = given or {}

    def type_of(self, path: Path) -> str:
        """Return the type that a parameter for the value at a path has."""
        keys = [key for key in path if isinstance(key, str)]
        last = keys[-1] if keys else ""
        if keys[:1] == [GIVEN]:
            return {"sign": "integer"}.get(self.given.get(keys[1], "number"), self.given.get(keys[1], "number"))
        if self.kind and keys[:1] in (["limit"], ["safety_controller"], ["dynamics"]):
            return (_TURNING if self.turns else _SLIDING).get(last, "number")
        return _TYPES.get(last, "number") if last != "offset" or self.turns else "length"


def owners(nodes: Sequence[Node]) -> list[Owner]:
    """Return what has values among the nodes of a part; the place of its root is that of the use."""
    made = []
    for index, node in enumerate(nodes):
        kind = node.moves["type"].values[0] if node.joint else ""
        made.append(Owner(node.link, node.body))
        made.append(Owner(node.joint, node.moves, kind in ROTATING, kind))
        if index:
            made.append(Owner(node.joint, node.pose, kind in ROTATING, kind))
    return made


class Parameters:
    """Finds the parameters of one part; after ``settled`` its forms hold ``Term`` where they differ."""

    def __init__(self, uses: Sequence[str], prefixes: Sequence[str], mirrored: Sequence[bool], plain: bool) -> None:
        self.uses, self.prefixes, self.mirrored, self.plain = uses, prefixes, mirrored, plain
        self.all: list[Parameter] = []
        self.signs: dict[tuple[int, ...], Parameter] = {}
        self.known: dict[Any, Parameter] = {}
        self.long = False
        self.terms = 0

    @property
    def given(self) -> list[Parameter]:
        """The parameters that a use gives."""
        return [one for one in self.all if not one.own]

    def settle(self, those: Sequence[Owner]) -> None:
        """Put a term in the place of every value that differs."""
        self.long = len(those) > _SMALL
        for owner in those:
            self._within(owner, owner.entry, ())
        self._name()

    def _within(self, owner: Owner, entry: Form, path: Path) -> None:
        """Settle all that an entry holds."""
        for key, item in list(entry.items() if isinstance(entry, dict) else enumerate(entry)):
            here = (*path, key)
            if isinstance(item, Leaf):
                if not item.is_same:
                    entry[key] = self._leaf(owner, here, item)
            elif isinstance(item, list) and self._is_point(item):
                entry[key] = self._point(owner, here, item)
            elif isinstance(item, dict) and (key in _TABLES or path == (GIVEN,)) and _differing(item) >= _MANY:
                entry[key] = self._whole(owner, here, item, "table")
            elif isinstance(item, (dict, list)):
                self._within(owner, item, here)

    @staticmethod
    def _is_point(item: list[Form]) -> bool:
        return len(item) > 1 and all(isinstance(one, Leaf) and one.is_number for one in item)

    def _point(self, owner: Owner, path: Path, item: list[Leaf]) -> Form:
        """Return a list of numbers: as one parameter where two or more of them differ in more than their sign."""
        free = [one for one in item if not one.is_same and not _is_signed(one)]
        if len(free) > 1:
            return self._whole(owner, path, item, "list")
        return [one if one.is_same else self._leaf(owner, (*path, place), one) for place, one in enumerate(item)]

    def _leaf(self, owner: Owner, path: Path, leaf: Leaf) -> Term | Leaf:
        self.terms += 1
        if leaf.is_number:
            return self._sign(owner, path, leaf) if _is_signed(leaf) else self._number(owner, path, leaf)
        if all(isinstance(value, str) for value in leaf.values):
            return self._text(owner, path, leaf)
        kind = "boolean" if all(isinstance(value, bool) for value in leaf.values) else "any"
        return Term([self._known((kind, *map(repr, leaf.values)), leaf, kind, owner, path)])

    def _sign(self, owner: Owner, path: Path, leaf: Leaf) -> Term:
        """Return a number with the signs that it has in the instances."""
        first = leaf.values[0]
        signs = tuple(1 if value == first else -1 for value in leaf.values)
        return Term(self._factors(signs), spelt(first, _DEGREES.get(owner.type_of(path), "")))

    def _factors(self, signs: tuple[int, ...]) -> list[Parameter]:
        """Return the parameters whose product these signs are: one that is known, two of those, or a new one."""
        if signs in self.signs:
            return [self.signs[signs]]
        for one, first in self.signs.items():
            for other, second in self.signs.items():
                if one < other and tuple(a * b for a, b in zip(one, other, strict=True)) == signs:
                    return [first, second]
        own = signs == tuple(-1 if flag else 1 for flag in self.mirrored)
        form = Leaf(signs, (None,) * len(signs))
        made = Parameter(form, "sign", [side_word(self.uses, signs) or ("side" if own else "direction")], own)
        self.all.append(made)
        self.signs[signs] = made
        return [made]

    def _number(self, owner: Owner, path: Path, leaf: Leaf) -> Term:
        opposite = ("number", *(-value for value in leaf.values))
        if opposite in self.known:
            return Term([self.known[opposite]], "-1")
        return Term([self._known(("number", *leaf.values), leaf, owner.type_of(path), owner, path)])

    def _text(self, owner: Owner, path: Path, leaf: Leaf) -> Term:
        """Return a text that differs: by the name of its instance, or as a parameter."""
        if self.plain and not any("${" in text or "$(" in text for text in leaf.values):
            for word, those in (("name", self.uses), ("prefix", self.prefixes)):
                rows = [_parts(text, own, word) for text, own in zip(leaf.values, those, strict=True)]
                if rows[0] and all(row == rows[0] for row in rows):
                    self.terms -= 1
                    return _Pattern(Expression(f"${{{word}}}".join(rows[0])))
        before, after = _around(leaf.values) if path[-1] == "file" else ("", "")
        inner = tuple(text[len(before) : len(text) - len(after)] for text in leaf.values)
        given = Leaf(inner, leaf.spans)
        made = self._known(("text", *inner), given, "text", owner, path)
        return Term([made], "", escaped(before), escaped(after))

    def _whole(self, owner: Owner, path: Path, item: Form, kind: str) -> Term:
        """Return a list or a table that is given as a whole."""
        self.terms += 1
        key = (kind, *(leaf.values for _, _, _, leaf in leaves({"": item})))
        return Term([self._known(key, item, kind, owner, path)])

    def _known(self, key: Any, values: Form, kind: str, owner: Owner, path: Path) -> Parameter:
        if key not in self.known:
            words = [step for step in path if isinstance(step, str)]
            word = _CALLED.get(words[-1], words[-1]) if words else "value"
            place = path[-1] if isinstance(path[-1], int) and path[-1] < len(_AXES["xyz"]) else None
            axis = _AXES[words[-1]][place] if place is not None and words[-1] in _AXES else ""
            hint = [axis or word, f"{_plain(owner.name)}_{axis or word}"][self.long :]
            if kind == "number" and any(isinstance(value, Quantity) for value in values.values):
                kind = "any"
            self.known[key] = Parameter(_degrees(owner, path, values), kind, hint)
            self.all.append(self.known[key])
        return self.known[key]

    def _name(self) -> None:
        """Give the parameters names: the word for what they are, with their owner's where two would be called so."""
        count = Counter(one.hint[0] for one in self.all)
        taken: set[str] = set()
        for one in self.all:
            wanted = identifier(one.hint[-1] if count[one.hint[0]] > 1 and one.kind != "sign" else one.hint[0])
            name, number = wanted, 1
            while name in taken or _is_taken(name, one.kind == "sign"):
                number += 1
                name = f"{wanted}_{number}"
            taken.add(name)
            one.name = name


class _Pattern(Term):
    """A text with the name of its instance in it."""

    def __init__(self, text: Expression) -> None:
        super().__init__([])
        self.text = text

    def expression(self) -> Expression:
        return self.text


def _parts(text: str, own: str, word: str) -> list[str]:
    """Return a text around the name of its instance, which stands in it as a word; nothing if it does not."""
    if not own:
        return []
    found = re.split(re.escape(own) if word == "prefix" else _AS_A_WORD.format(re.escape(own)), text)
    return [escaped(piece) for piece in found] if len(found) > 1 else []


def _around(texts: Sequence[str]) -> tuple[str, str]:
    """Return the folder and the ending that names of files have in common."""
    folders = {text.rpartition("/")[0] for text in texts}
    endings = {text.rpartition(".")[2] for text in texts if "." in text.rpartition("/")[2]}
    before = f"{folders.pop()}/" if len(folders) == 1 and all("/" in text for text in texts) else ""
    after = f".{endings.pop()}" if len(endings) == 1 and all("." in text[len(before) :] for text in texts) else ""
    return before, after


def _is_taken(name: str, sign: bool) -> bool:
    return means_something(name) or (name in _TAKEN and not (sign and name in ("side", "end")))


def means_something(name: str) -> bool:
    """Say whether a name has a meaning in every expression: a unit, a function, a constant, a word such as ``if``."""
    known = expression_names()
    return name in known.units or name in known.functions or name in known.constants or iskeyword(name)


def identifier(text: str) -> str:
    """Return a name for expressions that is like a text."""
    made = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_").lower()
    return made if made and not made[0].isdigit() else f"n_{made}".strip("_")


def _plain(name: str) -> str:
    """Return a name of a part without its expressions."""
    counted = re.sub(r"\$\{first \+ (\d+)\}", r"\1", name).replace("${first}", "0")
    return counted.replace("${name}", "")


def _is_signed(leaf: Leaf) -> bool:
    """Say whether a number differs in its sign alone."""
    return leaf.is_number and len({abs(value) for value in leaf.values}) == 1


def _differing(entry: Form) -> int:
    return sum(not leaf.is_same and not _is_signed(leaf) for _, _, _, leaf in leaves(entry))


def spelt(value: float, unit: str = "") -> str:
    """Return a number as it stands in an expression."""
    if isinstance(value, Quantity) and value.text:
        return value.text
    return (unit and math.isfinite(value) and in_degrees(value, unit)) or exact(value)


def _degrees(owner: Owner, path: Path, values: Form) -> Form:
    """Return the values of a parameter, angles in the degrees that a person would write."""
    if isinstance(values, Leaf):
        unit = _DEGREES.get(owner.type_of(path), "")
        return in_unit(values, unit) if unit and values.is_number else values
    items = values.items() if isinstance(values, dict) else enumerate(values)
    made = {key: _degrees(owner, (*path, key), item) for key, item in items}
    return made if isinstance(values, dict) else list(made.values())


def in_unit(leaf: Leaf, unit: str) -> Leaf:
    """Return angles as quantities in degrees where those are short and exact."""
    texts = [in_degrees(value, unit) if value and math.isfinite(value) else "" for value in leaf.values]
    values = tuple(Quantity.parse(text) if text else own for text, own in zip(texts, leaf.values, strict=True))
    return Leaf(values, leaf.spans)


def differences(one: Form, other: Form) -> Iterator[tuple[str, int]]:
    """Yield what differs between two forms of the same shape: ``sign`` or ``value``, and how often.

    What is likely to be one parameter counts once: a list, a small table.
    """
    items = one.items() if isinstance(one, dict) else enumerate(one)
    for key, item in items:
        twin: Any = other[key] if not isinstance(one, dict) or key in other else None
        if isinstance(item, Leaf):
            if item.is_number and item.values != twin.values:
                signed = all(abs(a) == abs(b) for a, b in zip(item.values, twin.values, strict=True))
                yield ("sign" if signed else "value"), 1
        elif isinstance(item, dict) and isinstance(twin, dict) and item.keys() != twin.keys():
            yield from differences(dict(enumerate(item.values())), dict(enumerate(twin.values())))
        elif isinstance(item, (dict, list)):
            inner = list(differences(item, twin))
            values = sum(kind == "value" for kind, _ in inner)
            table = isinstance(item, dict) and key in _TABLES and values >= _MANY
            if values > 1 and (table or (isinstance(item, list) and Parameters._is_point(item))):
                yield "value", 1
            else:
                yield from inner
