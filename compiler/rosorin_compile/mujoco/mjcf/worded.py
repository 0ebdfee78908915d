"""Worded: attributes of MuJoCo's elements as keys of a description, by the forms that the schema has for them.

An element comes as ``resolved`` gives it: a tag, attributes as texts, and what stands in it. What no key can say is
left over, and the element is then kept as it is: ``text_of``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

from rosorin_compile.language.schema import resolve, schema
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .reading import legal, numbers, plain, put, tidy
from .source import says

Attributes = Mapping[str, str]
Node = Mapping[str, Any]

_NAMES = "#/$defs/name"


def forms_of(name: str) -> Mapping[str, Any]:
    """Return the keys that an entry of a kind may have, by name, with their schemas."""
    forms: Mapping[str, Any] = schema()["$defs"][name]["properties"]
    return forms


def put_words(
    entry: Map,
    attributes: Attributes,
    kind: str,
    element: Element,
    words: Mapping[str, str] | None = None,
    rename: Callable[[str, str], str] = lambda _, name: name,
) -> dict[str, str]:
    """Set the keys of an entry that attributes say, in their order; return the attributes that no key can say.

    ``words`` are the keys that are called otherwise than the attribute. What the language has no word for goes into
    ``mjcf``. ``rename`` makes of an attribute and a name in it the name that the description has.
    """
    forms, called = forms_of(kind), words or {}
    more = resolve(forms.get("mjcf", {})).get("properties", {})
    kept, rest = Map(element.span), {}
    for name, text in attributes.items():
        if name == "name":
            continue
        key = called.get(name, name)
        own = key in forms and key not in ("mjcf", "name", "source", "xyz", "rpy")
        value = value_of(text, forms[key], element, name, rename) if own else None
        target = entry
        if value is None:
            key, target = name, kept
            value = value_of(text, more[name], element, name, rename) if name in more else None
        if value is None:
            rest[name] = text
        else:
            put(target, key, value, _span(element, name, text))
    if kept:
        put(entry, "mjcf", kept)
    return rest


def value_of(
    text: str,
    form: Mapping[str, Any],
    element: Element,
    attribute: str,
    rename: Callable[[str, str], str] = lambda _, name: name,
) -> Any:
    """Return the value of an attribute in a form of the schema; None if the form does not take it."""
    if form.get("$ref") == _NAMES:
        return rename(attribute, text)
    if "$ref" in form:
        form = {"minItems": 3, "maxItems": 4, "type": "array"} if form["$ref"] == "#/$defs/rgba" else form
    kinds = form.get("type", "string")
    if "enum" in form or kinds == "string":
        return text if text in form.get("enum", (text,)) else None
    if kinds == "boolean":
        return {"true": True, "false": False}.get(text)
    found = _numbers(text)
    if not found:
        return None
    if len(found) == 1 and ("number" in kinds or kinds == "integer"):
        return int(found[0]) if kinds == "integer" else plain(found[0])
    if "array" not in kinds or not form.get("minItems", 0) <= len(found) <= form.get("maxItems", len(found)):
        return None
    return numbers(found, element, attribute)


def _numbers(text: str) -> list[float]:
    try:
        return [tidy(float(word)) if float(word) else 0.0 for word in text.split()]
    except ValueError:
        return []


def _span(element: Element, attribute: str, text: str) -> Any:
    """Return the place of the attribute in the file, if it says this very number there."""
    own = element.attributes.get(attribute)
    words = own.words() if own else []
    if own is None or own.value == text:
        return own.span if own else element.span
    one = len(words) == 1 and len(text.split()) == 1 and _numbers(text) and says(words[0].text, float(text))
    return own.span if one else element.span


def floats(attributes: Attributes, name: str, usual: Sequence[float] = ()) -> list[float]:
    """Return the numbers of an attribute; those that it does not say are the usual ones."""
    found = [float(word) for word in attributes.get(name, "").split()]
    return [*found, *usual[len(found) :]]


def listing(values: Sequence[Any], element: Element) -> Seq:
    """Return values as a list that stands where an element is."""
    made = Seq(element.span)
    for value in values:
        made.put(value, element.span)
    return made


def text_of(node: Node, changed: Attributes | None = None, indent: str = "") -> str:
    """Return an element as XML; ``changed`` stand instead of its own attributes."""
    attributes = node["attributes"] if changed is None else changed
    said = "".join(f" {name}={quoteattr(legal(text) if name == 'name' else text)}" for name, text in attributes.items())
    if not node["inner"]:
        return f"{indent}<{node['tag']}{said}/>"
    inner = "\n".join(text_of(one, None, f"{indent}  ") for one in node["inner"])
    return f"{indent}<{node['tag']}{said}>\n{inner}\n{indent}</{node['tag']}>"
