"""The language reference, made from the JSON Schemas of descriptions, so that it cannot fall behind.

    python docs/make/reference.py [PAGE]

writes docs/language.md and one page per section of the language into docs/language/, or prints one of these pages;
``python tests/renew.py docs`` writes them too. What a schema cannot express is in ``docs/_language_head.md``, with
marks such as ``<!-- units -->`` where a generated table goes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from authoring import documented_schema
from rosorin_compile.formats import FORMATS
from rosorin_compile.language.expression.functions import BUILT_IN, CONSTANTS
from rosorin_compile.language.schema import of_types
from rosorin_compile.source.units import DIMENSIONS, UNITS, describe

DOCS = Path(__file__).parents[1]
HEAD = DOCS / "_language_head.md"
SHARED = "shared"
CONTAINERS = {"parts", "use"}  # their entries have most sections themselves
MADE = "<!-- Made by docs/make/reference.py from the schema. -->"
_KEYS = ("key", "value", "unit", "needed", "meaning")
_WORDS = {
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "array": "list",
    "object": "mapping",
}
_TYPES = {
    "any": "anything",
    "text": "text",
    "boolean": "`true` or `false`",
    "integer": "a whole number",
    "number": "a number without a unit",
    "list": "a list",
    "table": "a mapping",
}

Schema = Mapping[str, Any]


def language() -> Schema:
    """Return the schema of descriptions with what the plain tree has no more: parts, uses, named values, ..."""
    schema = documented_schema(FORMATS.values())
    definitions = schema["$defs"]
    definitions["use"]["type"] = definitions["use"]["properties"]["with"]["type"] = "object"
    keys = definitions["sensor"]["properties"]
    definitions["sensor_type"]["properties"] |= {name: keys[name] for name in of_types()}
    return schema


def reference(schema: Schema, head: str = "") -> dict[str, str]:
    """Return the pages by their paths below docs/: language.md begins with ``head``, whose marks are filled in.

    The schema has its definitions in ``$defs`` and names the unit of a number in ``x-unit``. An entry is described on
    the page of the section that uses it, apart from ``parts`` and ``use``; entries of several sections, and single
    values, are on language/shared.md.
    """
    users: dict[str, list[str]] = {}
    for section in schema["properties"]:
        walk = _Walk(schema, section, {})
        list(walk.lines(schema["properties"][section]))
        for title in walk.fragments:
            users.setdefault(title, []).append(section)
    homes = {}
    for title, used in users.items():
        own = [section for section in used if section not in CONTAINERS] or used[-1:]
        if len(own) == 1:
            homes[title] = own[0]
    shared = _Walk(schema, SHARED, homes)
    pages = {"language": "\n".join([*_filled(head), *_Walk(schema, "", homes).sections()])}
    for section, fragment in schema["properties"].items():
        walk = _Walk(schema, section, homes)
        pages[f"language/{section}"] = "\n".join(walk.lines(fragment))
        shared.ask(walk.fragments)
    pages[f"language/{SHARED}"] = "\n".join(shared.shared())
    return {f"{name}.md": text + "\n" for name, text in sorted(pages.items())}


def _filled(head: str) -> Iterator[str]:
    """Yield the lines of the head with the tables that its marks ask for."""
    tables = {"<!-- units -->": _units, "<!-- functions -->": _functions, "<!-- constants -->": _constants}
    tables["<!-- types -->"] = _types
    for line in head.splitlines():
        yield from tables[line]() if line in tables else (line,)


def _units() -> Iterator[str]:
    """Yield a table of the units by what they measure."""
    by_meaning: dict[str, list[str]] = {}
    for name, (_, dimension) in UNITS.items():
        by_meaning.setdefault(describe(dimension), []).append(f"`{name}`")
    rows = [(_escaped(meaning), ", ".join(names)) for meaning, names in by_meaning.items()]
    yield from _table(("quantity (SI unit)", "units"), rows)


def _functions() -> Iterator[str]:
    """Yield a table of the functions; those of which the same is said share a row."""
    by_help: dict[str, list[str]] = {}
    for function in BUILT_IN:
        by_help.setdefault(function.help, []).append(f"`{function.name}`")
    rows = [(", ".join(names), help) for help, names in by_help.items()]
    yield from _table(("function", "result"), rows)


def _types() -> Iterator[str]:
    """Yield a table of the types that an argument or a parameter may have."""
    rows = [(f"`{name}`", meaning) for name, meaning in _TYPES.items()]
    rows += [(f"`{name}`", _escaped(describe(dimension))) for name, dimension in DIMENSIONS.items()]
    yield from _table(("type", "what it takes"), rows)


def _constants() -> Iterator[str]:
    yield ", ".join(f"`{name}`" for name in CONSTANTS)


def _table(headers: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> Iterator[str]:
    """Yield a table without the columns in which no row says anything."""
    used = [index for index in range(len(headers)) if any(row[index] for row in rows)]
    yield f"| {' | '.join(headers[index] for index in used)} |"
    yield f"|{'---|' * len(used)}"
    for row in rows:
        yield f"| {' | '.join(row[index].replace('|', chr(92) + '|') for index in used)} |"


class _Walk:
    """The walk from one section of the schema over its entries, each of which is described once, on its page."""

    def __init__(self, schema: Schema, page: str, homes: Mapping[str, str]) -> None:
        self.top = schema
        self.definitions: Schema = schema["$defs"]
        self.page = page
        self.homes = homes
        self.fragments: dict[str, Schema] = {}
        self.waiting: list[tuple[str, Schema]] = []
        self.values: list[tuple[str, str]] = []

    def sections(self) -> Iterator[str]:
        """Yield the table of all sections for the page of the language."""
        yield from ("## Sections of a description", "", _sentence(self.top["description"]), "")
        yield "Every section has a page. [Shared entries](language/shared.md) are used in several sections."
        yield from ("", *self.keys(self.top, lambda key: f"[`{key}`](language/{key}.md)"))

    def lines(self, fragment: Schema) -> Iterator[str]:
        """Yield the page of a section: what it is for, its form, and the entries that only this section uses."""
        needed = " It is required." if self.page in self.top.get("required", ()) else ""
        kind = _capital(self.kind(fragment, f"{self.page} entry"))
        described = fragment.get("description") or self.resolved(fragment).get("description", "")
        yield from (f"# {self.page}", "", MADE, "")
        yield f"Read this page to write the section `{self.page}` of a [description](../language.md).{needed}"
        yield from ("", _sentence(described), "", f"Form: {kind}")
        yield from self.entries()

    def shared(self) -> Iterator[str]:
        """Yield the page of the entries that several sections use, and of the values that many entries use."""
        yield from ("# Shared entries", "", MADE, "")
        yield "Read this page when the page of a section refers to it: several sections use these entries and values."
        yield from self.entries()
        yield from ("", "## Values")
        for title, text in self.values:
            yield from ("", f"### {title}", "", text)

    def entries(self) -> Iterator[str]:
        """Yield the entries of this page in the order of the walk; collect the definitions without keys."""
        while self.waiting:
            title, fragment = self.waiting.pop(0)
            if "properties" not in fragment:
                text = _capital(f"{self.kind(fragment)}. {_sentence(fragment['description'])}")
                self.values.append((title, text))
                continue
            later, self.waiting = self.waiting, []
            yield from ("", f"## {title}", "", *self.entry(fragment))
            self.waiting += later

    def ask(self, fragments: Mapping[str, Schema]) -> None:
        """Have the entries of another page described here as far as they belong here."""
        for title, fragment in fragments.items():
            self.link(title, fragment)

    def entry(self, fragment: Schema) -> Iterator[str]:
        """Yield what an entry is for, its keys, and which of them go together."""
        yield from (_sentence(fragment["description"]), "", *self.keys(fragment))
        together = [(key, *others) for key, others in fragment.get("dependencies", {}).items()]
        if together:
            groups = dict.fromkeys(" and ".join(f"`{key}`" for key in sorted(group)) for group in together)
            yield from ("", f"{', '.join(groups)} are given together.")
        least, most = fragment.get("minProperties"), fragment.get("maxProperties")
        if least and not fragment.get("required"):
            yield from ("", f"It has {'one of these keys' if most == least else 'at least one of these keys'}.")

    def keys(self, fragment: Schema, shown: Callable[[str], str] = "`{}`".format) -> Iterator[str]:
        """Yield the table of the keys of an entry: first those that are needed, then in the order of the schema."""
        needed = fragment.get("required", [])
        rows = []
        for key in sorted(fragment["properties"], key=lambda key: key not in needed):
            value = fragment["properties"][key]
            meaning = _sentence(value.get("description") or self.resolved(value).get("description", ""))
            kind = self.kind(value, f"{key} entry")
            rows.append((shown(key), kind, self.unit(value), _needed(key, value, needed), meaning))
        yield from _table(_KEYS, rows)

    def kind(self, fragment: Schema, title: str = "") -> str:
        """Return what may stand as a value, with links to the sections of entries."""
        if "$ref" in fragment:
            name = fragment["$ref"].rsplit("/", 1)[1]
            return self.link(name, self.definitions[name])
        if "anyOf" in fragment:
            return self.kind(fragment["anyOf"][0], title)
        if "const" in fragment:
            return f"`{fragment['const']}`"
        if "enum" in fragment:
            return ", ".join(f"`{option}`" for option in dict.fromkeys(map(str, fragment["enum"])))
        types = fragment.get("type", [])
        names = [types] if isinstance(types, str) else [name for name in types if name != "null"]
        if "properties" in fragment and title:
            return self.link(title, fragment)
        if names == ["array"]:
            return self.list_of(fragment, title)
        inner = fragment.get("additionalProperties")
        if names == ["object"] or (names and isinstance(inner, dict)):
            mapping = f"name: {self.kind(inner, title)}" if isinstance(inner, dict) else "name: any value"
            return " or ".join([*(_WORDS[name] for name in names if name != "object"), mapping])
        return " or ".join(_WORDS[name] for name in names) or "any value"

    def link(self, title: str, fragment: Schema) -> str:
        """Return a link to an entry or a value; the first link to one of this page has it described."""
        home = self.homes.get(title, SHARED) if "properties" in fragment else SHARED
        here = home == self.page or not self.homes
        if title not in self.fragments:
            self.fragments[title] = fragment
            if here:
                self.waiting.append((title, fragment))
            elif "properties" not in fragment:
                self.kind(fragment)  # the entries that the value consists of
        page = "" if here else f"{home}.md" if self.page else f"language/{home}.md"
        types = fragment.get("type", ())
        also = "text or " if "properties" in fragment and "string" in types and types != "string" else ""
        several = f" or {self.list_of(fragment, '')}" if {"properties", "items"} <= fragment.keys() else ""
        return f"{also}[{title}]({page}#{title.replace(' ', '-').lower()}){several}"

    def list_of(self, fragment: Schema, title: str) -> str:
        inner = self.kind(fragment["items"], title) if "items" in fragment else "any values"
        least, most = fragment.get("minItems"), fragment.get("maxItems")
        if least is not None and least == most:
            return f"list of {least}: {inner}"
        return f"list of {inner}"

    def unit(self, fragment: Schema) -> str:
        """Return the SI unit of a number, or of the numbers in a list or a mapping; two where it depends."""
        fragment = self.resolved(fragment)
        while "x-unit" not in fragment:
            inner = fragment.get("items", fragment.get("additionalProperties"))
            if not isinstance(inner, dict) or "properties" in self.resolved(inner):
                return ""
            fragment = self.resolved(inner)
        units = fragment["x-unit"]
        return " or ".join(f"`{unit}`" for unit in ([units] if isinstance(units, str) else units) if unit)

    def resolved(self, fragment: Schema) -> Schema:
        reference: str = fragment.get("$ref", "")
        found: Schema = self.definitions[reference.rsplit("/", 1)[1]] if reference else fragment
        return found


def _needed(key: str, fragment: Schema, required: list[str]) -> str:
    if key in required:
        return "**required**"
    if "default" in fragment:
        return f"default `{fragment['default']}`"
    return "optional"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _sentence(text: str) -> str:
    """Return a description with a full stop, so that it can stand in running text."""
    return _escaped(text if text.endswith((".", ".)")) or not text else f"{text}.")


def _escaped(text: str) -> str:
    """Return text that Markdown shows as it is."""
    return text.replace("<", "&lt;").replace("*", "\\*")


def pages() -> dict[str, str]:
    """Return the pages as they are committed, by their paths below docs/."""
    return reference(language(), HEAD.read_text("utf-8"))


if __name__ == "__main__":
    made = pages()
    if len(sys.argv) > 1:
        sys.stdout.write(made[sys.argv[1]])
    for name in made if len(sys.argv) == 1 else ():
        (DOCS / name).write_text(made[name], "utf-8")
