"""Turn the values that differ between the instances of a part into a few parameters.

Numbers that differ only in sign share a sign parameter. A text that contains the name of its use becomes an expression
with ``${name}``. A list in which several numbers differ is one parameter, and equal values in several places share one.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from keyword import iskeyword
from typing import Any

from rosorin_compile.language.expression.functions import reserved_names
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import Quantity

from ..layout import Expression, escape
from .nodes import is_number

_WORDS = {"lower": "lower_limit", "upper": "upper_limit", "file": "mesh", "rgba": "colour", "material": "look"}
_AXES = {"xyz": ("x", "y", "z"), "rpy": ("roll", "pitch", "yaw")}


@dataclass
class Parameter:
    """A parameter of a part: its name, its type, and its value in each instance.

    A sign is 1 or -1; one that ``is_derived`` is computed by the part from ``mirrored``.
    """

    name: str
    kind: str
    values: Sequence[Any]
    is_derived: bool = False

    @property
    def default(self) -> Any:
        """The value of at least half of the instances, or None."""
        text, count = Counter(map(repr, self.values)).most_common(1)[0]
        has_default = self.kind != "sign" and count > 1 and 2 * count >= len(self.values)
        return next(value for value in self.values if repr(value) == text) if has_default else None

    @property
    def entry(self) -> dict[str, Any]:
        """Its entry under ``params``."""
        if self.kind == "sign":
            return {"type": "integer", "one_of": [1, -1]}
        entry = {} if self.kind == "any" else {"type": self.kind}
        return entry if self.default is None else {**entry, "default": self.default}


class Parameters:
    """The parameters of one part.

    ``uses``, ``prefixes`` and ``mirrored`` have the name of the use, the prefix of its names and whether it is
    mirrored, for each instance. ``count`` is the number of values that became expressions.
    """

    def __init__(self, uses: Sequence[str], prefixes: Sequence[str], mirrored: Sequence[bool]) -> None:
        self.uses, self.prefixes, self.mirrored = uses, prefixes, mirrored
        self.count = 0
        self._index: dict[Any, Parameter] = {}

    @property
    def arguments(self) -> list[Parameter]:
        """The parameters that a use gives."""
        return [one for one in self._index.values() if not one.is_derived]

    @property
    def derived(self) -> dict[str, Expression]:
        """The parameters that the part computes."""
        names = [one.name for one in self._index.values() if one.is_derived]
        return dict.fromkeys(names, Expression("${-1 if mirrored else 1}"))

    def replace(self, values: Mapping[Path, Sequence[Any]], owner: str) -> dict[Path, Any]:
        """Return an expression for each value, or list of values, that differs between instances.

        ``owner`` names the link or joint.
        """
        differing = [path for path, some in values.items() if any(value != some[0] for value in some[1:])]
        numbers = [path for path in differing if isinstance(path[-1], int) and all(map(is_number, values[path]))]
        points = Counter(path[:-1] for path in numbers if not _is_sign(values[path]))
        terms: dict[Path, Any] = {}
        for unit in dict.fromkeys(path[:-1] if points[path[:-1]] > 1 else path for path in differing):
            some = values.get(unit, ())
            if unit not in values:
                columns = [values[path] for path in values if path[:-1] == unit]
                text = f"${{{self._parameter('any', list(zip(*columns, strict=True)), unit, owner)}}}"
            elif all(map(is_number, some)) and _is_sign(some):
                text = f"${{{self._signed(some)}}}"
            elif all(isinstance(value, str) for value in some):
                text = self._text(some, unit, owner)
            else:
                kind = "boolean" if all(isinstance(one, bool) for one in some) else "any"
                text = f"${{{self._parameter(kind, some, unit, owner)}}}"
            terms[unit] = Expression(text)
        self.count += len(terms)
        return terms

    def _parameter(self, kind: str, values: Sequence[Any], path: Path, owner: str) -> str:
        """Return the name of the parameter with these values, creating it if necessary."""
        key = (kind, repr(list(values)))
        if key not in self._index:
            words = [step for step in path if isinstance(step, str)]
            word = _WORDS.get(words[-1], words[-1])
            if isinstance(path[-1], int) and words[-1] in _AXES:
                word = _AXES[words[-1]][path[-1]]
            taken = [one.name for one in self._index.values()]
            if owner and _identifier(word) in taken:
                word = f"{re.sub(r'[$][{][^}]*[}]', '', owner)}_{word}"
            self._index[key] = Parameter(free_name(_identifier(word), taken), kind, values)
        return self._index[key].name

    def _signed(self, values: Sequence[Any]) -> str:
        """Return the product of the first value with a sign parameter."""
        signs = tuple(1 if value == values[0] else -1 for value in values)
        if signs not in self._index:
            is_derived = any(self.mirrored) and signs == tuple(-1 if flag else 1 for flag in self.mirrored)
            word = "side" if is_derived else "direction"
            name = free_name(word, [one.name for one in self._index.values()])
            self._index[signs] = Parameter(name, "sign", signs, is_derived)
        value = values[0]
        text = value.text if isinstance(value, Quantity) and value.text else exact(value)
        return f"{text[:-1] if text in ('1', '-1') else f'{text} * '}{self._index[signs].name}"

    def _text(self, texts: Sequence[str], path: Path, owner: str) -> str:
        """Return an expression with the name or prefix of the use, or a parameter for what differs between texts."""
        if all(self.uses) and not any("${" in text or "$(" in text for text in texts):
            for word, names in (("name", self.uses), ("prefix", self.prefixes)):
                pattern = r"{}" if word == "prefix" else r"(?<![A-Za-z0-9]){}(?![A-Za-z0-9])"
                rows = {
                    tuple(re.split(pattern.format(re.escape(name)), text)) if name else ()
                    for text, name in zip(texts, names, strict=True)
                }
                if len(rows) == 1 and len(pieces := rows.pop()) > 1:
                    return f"${{{word}}}".join(map(escape, pieces))
        before = after = ""
        if path[-1] == "file":  # the parameter is the part that differs between folder and extension
            folders, endings = ({text.rpartition(sign)[i] for text in texts} for sign, i in (("/", 0), (".", 2)))
            before = f"{min(folders)}/" if len(folders) == 1 and all("/" in text for text in texts) else ""
            after = f".{min(endings)}" if len(endings) == 1 and all("." in t[len(before) :] for t in texts) else ""
        middles = [text[len(before) : len(text) - len(after)] for text in texts]
        name = self._parameter("text", middles, path, owner)
        return f"{escape(before)}${{{name}}}{escape(after)}"


def free_name(wanted: str, taken: Iterable[str]) -> str:
    """Return a name that is not taken and has no meaning in expressions, with a number if necessary."""
    reserved = {*reserved_names(), *taken}
    name, number = wanted, 1
    while name in reserved or iskeyword(name):
        number += 1
        name = f"{wanted}_{number}"
    return name


def _identifier(text: str) -> str:
    """Return a name for expressions that resembles a text."""
    name = re.sub(r"[\W_]+", "_", text, flags=re.ASCII).strip("_").lower()
    return name if name and not name[0].isdigit() else f"n_{name}".strip("_")


def _is_sign(values: Sequence[Any]) -> bool:
    return len({abs(value) for value in values}) == 1
