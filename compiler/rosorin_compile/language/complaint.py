"""Complaints: what the validator of the schema says against a tree, told in the words of the description."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from rosorin_compile.source.diagnostics import Diagnostic, swaps
from rosorin_compile.source.rule_registry import ARGUMENTS, SHAPE, Rule
from rosorin_compile.source.tree import Map, Seq, locate
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.wording import counted, in_words, unseen

from .expand.provenance import problem_at
from .expand.scope import Scope
from .misnamed import fallen_out, is_meant, key_meant, text_tails, word_meant
from .schema import Steps, part_at, resolve, subject
from .suggestions import (
    flag_meant,
    inner_number,
    items_meant,
    list_meant,
    mapping_meant,
    number_meant,
    numbers_in,
    plain_number,
    text_meant,
)
from .synonyms import way_out, words_for
from .validator import Misfit

RULES = (
    Rule(
        "bad-name",
        "A name has a form that it may not have, such as `<` or a quote, or a space at its end.",
        "Letters, digits and `_` are safe. Spaces within and `/` are allowed; names of values and arguments are plain "
        "words.",
        ARGUMENTS,
    ),
    Rule(
        "unknown-key",
        "An entry has no such key.",
        "The message names the nearest one and all that are legal.",
        SHAPE,
    ),
    Rule("missing-key", "An entry lacks a key that it needs.", "Add it.", SHAPE),
    Rule(
        "wrong-type",
        "A value is of another type: a text where a number belongs, a unit that nobody knows.",
        "Write what the message asks for.",
        SHAPE,
    ),
    Rule("wrong-value", "A value is not one of those that are allowed.", "Choose one of them.", SHAPE),
    Rule("wrong-length", "A list has too many or too few items.", "Positions have three numbers, pairs two.", SHAPE),
    Rule("empty-text", "A text that says something is empty.", "Say it, or leave the key out.", SHAPE),
    Rule(
        "wrong-shape",
        "A value does not fit the schema in another way.",
        "Compare it with [the language](language.md#sections-of-a-description).",
        SHAPE,
    ),
)

# Sections that expansion has made plain entries of: the schema of the plain tree lacks them.
_EXPANDED = ("parts", "sensor_types", "use")


_MEANING = {"&": "an anchor", "#": "a comment", "!": "a tag"}


_LIMITS = {
    "minimum": "{where} is {value}, less than {limit}",
    "maximum": "{where} is {value}, more than {limit}",
    "exclusiveMinimum": "{where} is {value}, and has to be more than {limit}",
    "exclusiveMaximum": "{where} is {value}, and has to be less than {limit}",
    "multipleOf": "{where} is {value}, no multiple of {limit}",
    "maxLength": "{where} is longer than {limit}",
    "uniqueItems": "{where} has an item twice",
}


class Complaint:
    """One complaint of the validator, told in the words of the description."""

    def __init__(self, tree: Map, misfit: Misfit, schema: Mapping[str, Any], scope: Scope | None) -> None:
        self.tree = tree
        self.scope = scope
        self.misfit = misfit
        self.path = misfit.path
        self.where = subject(self.path)
        self.keyword = "propertyNames" if "propertyNames" in misfit.schema_path[-2:-1] else misfit.keyword
        self.part, self.defined = part_at(misfit.schema_path[:-1], schema)
        node: Any = tree
        for step in self.path:
            node = node[step]
        self.value = node

    def diagnostics(self) -> list[Diagnostic]:
        wanted = self.misfit.wanted
        if self.keyword in ("minItems", "maxItems"):
            return [self._count(f"at {'least' if self.keyword == 'minItems' else 'most'} {wanted}")]
        if words := _LIMITS.get(self.keyword):
            limit = counted(wanted, "letter") if self.keyword == "maxLength" else wanted
            message = words.format(where=self.where, value=self.value, limit=limit)
            plain = self.keyword in ("minimum", "maximum")
            return [self._make("wrong-value", message) if plain else self._beyond(message)]
        method = getattr(self, f"_{self.keyword.lower()}", self._other)
        told: list[Diagnostic] = method()
        return told

    def _make(
        self,
        rule: str,
        message: str,
        help: str | Callable[[], str] = "",
        path: Steps | None = None,
        key: bool = False,
    ) -> Diagnostic:
        """Return an error; a help that takes long to compute is a function, which ``messages`` calls."""
        path = self.path if path is None else path
        if isinstance(help, str):
            return problem_at(self.scope, self.tree, path, rule, message, help, key=key)
        return replace(problem_at(self.scope, self.tree, path, rule, message, key=key), suggest=help)

    def _kind(self) -> str:
        if not self.path:
            return "top"
        return self.defined or str(self.path[0])

    def _additionalproperties(self) -> list[Diagnostic]:
        known = self.part.get("properties", {})
        if not self.path:
            known = {**known, **dict.fromkeys(_EXPANDED)}
        unexpected = dict.fromkeys(self.misfit.unexpected())
        tails, kind = text_tails(self.value, unexpected), self._kind()
        return [
            self._make(
                "unknown-key",
                f'{self.where} has no key "{key}"',
                partial(key_meant, key, self.value, known, kind, self.path),
                [*self.path, key],
                True,
            )
            for key in unexpected
            if key not in tails
        ]

    def _required(self) -> list[Diagnostic]:
        key = self.misfit.key
        legal = self.part.get("properties", {})
        meant = [other for other in self.value if other not in legal and is_meant(other, key, self._kind(), legal)]
        if key == "inertia" and any("of" in swaps(other) for other in self.value):
            return []  # which is in the place of it, and reported
        if meant and self.path[:1] != ["outputs"]:
            return []  # it is there, under a name that is reported
        if meant and key in swaps(meant[0]):  # other keys of outputs are judged when their format is known
            message = f'{self.where} has no key "{meant[0]}"'
            return [self._make("unknown-key", message, f'did you mean "{key}"?', [*self.path, meant[0]], True)]
        wanted = legal.get(key, {})
        meaning = wanted.get("description") or resolve(wanted).get("description", "")
        help = _sentence(meaning)
        if key == "inertia":
            help = "give ixx, iyy and izz, or write of: collision: then it is calculated from the shapes"
        return [self._make("missing-key", f'{self.where} needs the key "{key}"', help, self.path, key=True)]

    def _type(self) -> list[Diagnostic]:
        types = self.misfit.kinds()
        wanted = " or ".join(_TYPES[name] for name in types if name != "null")
        expected = self.part
        unit = expected.get("x-unit")
        if unit:
            wanted += f" ({unit if isinstance(unit, str) else ' or '.join(filter(None, unit))})"
        fallen = fallen_out(self.tree, self.path, expected)
        if self._is_told_as_list(types) or (fallen and not (fallen.is_first and "null" in types)):
            return []
        help: str | Callable[[], str]
        help = partial(self._type_help, types, [unit] if isinstance(unit, str) else unit or [], expected)
        if fallen:
            help = f'"{self.path[-1]}" is a key of such an entry: indent it deeper than "{fallen.owner}"'
        return [self._make("wrong-type", f"{self.where} is {wanted}, not {_found(self.value)}", help)]

    def _is_told_as_list(self, types: list[str]) -> bool:
        """Say whether a text is the only item of a list, and has all its numbers: the length is told."""
        node: Any = self.tree
        for step in self.path[:-1]:
            node = node[step]
        alone = isinstance(node, Seq) and len(node) == 1 and "number" in types and isinstance(self.value, str)
        return alone and len(numbers_in(self.value)) > 1

    def _type_help(self, types: list[str], units: list[str], expected: Mapping[str, Any]) -> str:
        sign = self._sign() if self.value is None else ""
        if sign:
            return f'"{sign}" begins {_MEANING[sign]} here: put the text in quotes'
        value, key = self.value, next((str(step) for step in reversed(self.path) if isinstance(step, str)), "")
        if set(types) & {"number", "integer"} and isinstance(value, str):
            return number_meant(value, units, key)
        if "integer" in types and isinstance(value, Quantity):
            return plain_number(float(value))
        if "number" in types and (told := inner_number(value, key)):
            return told
        if "array" in types:
            return list_meant(value, key, expected)
        if "object" in types:
            return self._of_items(value) or mapping_meant(value, self.path, expected)
        if value is None and "number" in types:
            return "write the number behind the colon, or leave the key out"
        if types == ["boolean"]:
            return flag_meant(value) or "write true or false"
        return text_meant(value, key, expected) if "string" in types else ""

    def _of_items(self, value: Any) -> str:
        """Return what the key of the first item of a list is told, where no list belongs and a table knows that key."""
        first = value[0] if isinstance(value, Seq) and value else None
        return way_out(next(iter(first), ""), words_for(self._kind())) if isinstance(first, Map) else ""

    def _sign(self) -> str:
        """Return the sign of YAML that an empty value begins with; "" if it has none."""
        span = locate(self.tree, self.path).span
        rest = span.source.line(span.line)[span.column - 1 :].lstrip()
        return rest[:1] if rest[:1] in _MEANING else ""

    def _enum(self) -> list[Diagnostic]:
        kind = {"joint": "joint type", "source": "status"}.get(self._kind(), "")
        kind = "which gazebo" if self.path[-1] == "gazebo" else kind
        return [not_allowed(self.tree, self.path, self.value, self.misfit.wanted, kind, self.scope)]

    def _const(self) -> list[Diagnostic]:
        help = f"this tool knows only {self.misfit.wanted}"
        return [self._make("wrong-value", f"{self.where} cannot be {self.value}", help)]

    def _count(self, wanted: str) -> Diagnostic:
        fragment = self.part
        if fragment.get("minItems") == fragment.get("maxItems"):
            wanted = str(fragment.get("minItems"))
        message = f"{self.where} has {counted(len(self.value), 'item')}, not {wanted}"
        help = items_meant(self.value, fragment) or _sentence(fragment.get("description", ""))
        return self._make("wrong-length", message, help)

    def _beyond(self, message: str) -> Diagnostic:
        return self._make("wrong-value", message, _sentence(str(self.part.get("description", ""))))

    def _pattern(self) -> list[Diagnostic]:
        help = _odd_letter(str(self.value)) or _sentence(str(self.part.get("description", "")))
        return [self._make("bad-name", f'{self.where} cannot be "{self.value}"', help)]

    def _propertynames(self) -> list[Diagnostic]:
        name = self.misfit.value
        message = f'"{name}" cannot be a name in {self.where}'
        plain = not self.defined  # else it is the form that links and joints have
        help = "use letters, digits and _" if plain else "no markup, no quotes; spaces only within"
        help = _odd_letter(str(name)) or help
        return [self._make("bad-name", message, help, [*self.path, name], True)]

    _dependencies = _required

    def _minlength(self) -> list[Diagnostic]:
        if self.value:
            return [self._beyond(f"{self.where} is shorter than {counted(self.misfit.wanted, 'letter')}")]
        return [self._make("empty-text", f"{self.where} is empty", "say something, or leave the key out")]

    def _minproperties(self) -> list[Diagnostic]:
        keys = ", ".join(self.part.get("properties", {}))
        return [self._make("missing-key", f"{self.where} is empty", f"legal keys: {keys}")]

    def _maxproperties(self) -> list[Diagnostic]:
        keys = ", ".join(self.part.get("properties", {}))
        return [self._make("wrong-value", f"{self.where} has more than one key", f"give one of {keys}")]

    def _other(self) -> list[Diagnostic]:
        help = _sentence(str(self.part.get("description", "")))
        return [self._make("wrong-shape", f"{self.where} does not fit the schema: {self.keyword}", help)]


def not_allowed(
    tree: Map, path: Steps, value: Any, options: Iterable[Any], kind: str = "", scope: Scope | None = None
) -> Diagnostic:
    """Return an error: the value at a path is not one of those that are allowed; ``kind`` is that of its synonyms."""
    allowed = list(options)
    names = list(dict.fromkeys(str(one).lower() if isinstance(one, bool) else str(one) for one in allowed))
    help = word_meant(str(value), names, kind)
    spelt = str(value).lower()
    if isinstance(value, bool) and spelt in allowed:
        message = f"{subject(path)} cannot be the flag {spelt}"
        return problem_at(scope, tree, path, "wrong-value", message, f'write "{spelt}" with quotes: it is a word here')
    if isinstance(value, str) and value in names:  # true is a word of YAML, "true" a text
        help = f"write {value} without quotes"
    elif isinstance(value, str) and "true" in names and (flag := flag_meant(value)):
        help = f"{flag} (one of {', '.join(names)})"
    elif help.startswith("did"):
        help += f" (one of {', '.join(names)})"
    return problem_at(scope, tree, path, "wrong-value", f'{subject(path)} cannot be "{value}"', help)


def _odd_letter(name: str) -> str:
    """Return the way out for a name with a space that no keyboard types by its bar, or a letter that nobody sees."""
    spaces = (letter for letter in name if letter.isspace() and letter not in " \n\t")
    odd = unseen(name) or next(spaces, "")
    return f"it has {in_words(odd)} in it: type the name anew" if odd else ""


_TYPES = {
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
    "object": "a mapping",
    "array": "a list",
}


def _sentence(text: str) -> str:
    return text[:1].lower() + text[1:].rstrip(".") if text else ""


def _found(value: Any) -> str:
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return f"{str(value).lower()}"
    if isinstance(value, Quantity):
        return f"the quantity {value.text or float(value)}"
    if isinstance(value, (int, float)):
        return f"the number {value}"
    if isinstance(value, str):
        return f'the text "{value}"'
    return "a list" if isinstance(value, Seq) else "a mapping"
