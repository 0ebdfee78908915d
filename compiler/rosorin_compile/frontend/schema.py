"""The JSON Schemas that ship with the tool: reading them, asking them about a path, naming a path in words."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cache, cached_property, lru_cache
from typing import TYPE_CHECKING, Any

from ..project import data_folder
from ..world import text
from .certain import Certain

if TYPE_CHECKING:
    from ..formats import Format

# An entry of outputs with this key is made by it, whatever its name.
TEMPLATE = "template"

# Sections that are one entry, not many by name.
ONE_ENTRY = ("drive", "moveit")
MANY_INSIDE = ("moveit",)  # of them those with entries by name, which several parts and files may add to

Steps = list[str | int]


def keys_of(section: str) -> Collection[str]:
    """Return the keys of a section that is one entry."""
    keys: Collection[str] = resolve(schema()["properties"][section])["properties"].keys()
    return keys


@cache
def schema(name: str = "description") -> dict[str, Any]:
    """Return one of the schemas that ship with the tool."""
    import json

    made: dict[str, Any] = json.loads(text(data_folder("schemas") / f"{name}.schema.json"))
    return made


@cache
def validator(name: str = "description") -> Any:
    """Return the validator of one of the schemas that ship with the tool."""
    return validator_of(schema(name))


def validator_of(schema: dict[str, Any]) -> Any:
    """Return the validator of a schema."""
    import jsonschema_rs

    return jsonschema_rs.Draft202012Validator(schema)


def with_outputs(outputs: Any, formats: Mapping[str, Format]) -> dict[str, Any]:
    """Return the schema of descriptions with the options of the outputs of one; each entry by its format."""
    entries: dict[str, Any] = {}
    for name, entry in outputs.items() if isinstance(outputs, Mapping) else ():
        called = entry.get("backend", backend_of(name, entry)) if isinstance(entry, Mapping) else ""
        if isinstance(called, str) and called in formats:
            entries[name] = {**_output(), "properties": {**_output()["properties"], **formats[called].options}}
    if not entries:
        return schema()
    whole, section = schema(), schema()["properties"]["outputs"]
    return {**whole, "properties": {**whole["properties"], "outputs": {**section, "properties": entries}}}


class Judge:
    """A schema, what says that a value certainly fits it, and its validator, which is made when it is asked for."""

    def __init__(self, schema: dict[str, Any]) -> None:
        self.schema = schema
        self.certain = Certain(schema)

    @cached_property
    def validator(self) -> Any:
        """What says where a value does not fit."""
        return validator_of(self.schema)


def judge_of(outputs: Any, formats: Mapping[str, Format]) -> Judge:
    """Return what judges a description with these outputs, made once for outputs of the same names and formats."""
    schema = with_outputs(outputs, formats)
    options = schema["properties"]["outputs"].get("properties", {})
    # The options of a format live as long as the program: the same ones are told by their identity.
    key = tuple((name, *map(id, one["properties"].values())) for name, one in options.items())
    if key not in _judges:
        if len(_judges) >= _MAX_JUDGES:
            _judges.clear()
        _judges[key] = Judge(schema)
    return _judges[key]


_judges: dict[tuple[Any, ...], Judge] = {}
_MAX_JUDGES = 100


def with_formats(formats: Iterable[Format]) -> dict[str, Any]:
    """Return the schema of descriptions with the options of every format, each with the formats that have it."""
    options: dict[str, dict[str, Any]] = {}
    meanings: dict[str, dict[str, list[str]]] = {}
    for one in formats:
        for key, option in one.options.items():
            known = options.setdefault(key, dict(option))
            if "enum" in known and "enum" in option:  # editors ask this schema; each format's own words are held later
                known["enum"] = [*known["enum"], *(value for value in option["enum"] if value not in known["enum"])]
            meanings.setdefault(key, {}).setdefault(option.get("description", ""), []).append(one.name)
    for key, option in options.items():
        texts = (f"{', '.join(names)}: {_uncapitalised(text)}" for text, names in meanings[key].items())
        option["description"] = " ".join(texts)
    output = {**_output(), "properties": {**_output()["properties"], **options}, "additionalProperties": False}
    return {**schema(), "$defs": {**schema()["$defs"], "output": output}}


def backend_of(name: str, entry: Mapping[str, Any]) -> str:
    """Return the backend of an entry of outputs that does not say it: its name, unless it names a template."""
    return TEMPLATE if TEMPLATE in entry else name


def _output() -> dict[str, Any]:
    output: dict[str, Any] = schema()["$defs"]["output"]
    return output


def _uncapitalised(text: str) -> str:
    return text[:1].lower() + text[1:] if text[1:2].islower() or text[1:2] == " " else text


@cache
def _certain(name: str) -> Certain:
    return Certain(schema(name))


def misfits(name: str, value: Any, large: bool = False) -> list[str]:
    """Return what of a JSON value does not fit one of the schemas that ship with the tool, a sentence each.

    With a ``large`` one the validator is sooner done, though it has to be imported first.
    """
    if not large and _certain(name).fits(value):
        return []
    return [f"{subject(list(p.instance_path))}: {p.message}" for p in validator(name).iter_errors(value)]


_ENTRIES = {
    "links": "link",
    "joints": "joint",
    "sensors": "sensor",
    "publishers": "publisher",
    "servos": "servo group",
    "poses": "pose",
    "control": "hardware block",
    "controllers": "controller",
    "materials": "material",
    "outputs": "output",
    "args": "argument",
    "modes": "mode",
}


def subject(path: Steps) -> str:
    """Return a path in words: ``joint "joint1" limit lower``.

    >>> subject(["joints", "joint1", "xyz", 2])
    'joint "joint1" xyz[2]'
    """
    if not path:
        return "the description"
    words: str = str(path[0])
    rest = path[1:]
    if path[0] in _ENTRIES and rest:
        words, rest = f'{_ENTRIES[str(path[0])]} "{rest[0]}"', rest[1:]
    for step in rest:
        words += f"[{step}]" if isinstance(step, int) else f" {step}"
    return words


def schema_at(path: Steps, whole: Mapping[str, Any] | None = None) -> Any:
    """Return the fragment of a schema at a path of it; an empty one if the path does not exist."""
    node: Any = schema() if whole is None else whole
    for step in path:
        if isinstance(node, dict):
            node = node.get(str(step), {})
        elif isinstance(node, list) and isinstance(step, int):
            node = node[step]
    return node


def unit_at(path: Sequence[str | int]) -> str | list[str] | None:
    """Return the unit (or units) that the schema asks for at a path of a description; "" for a plain number.

    None where the schema has no number at all.
    """
    # The names of entries and the indices of items make no difference: what is asked for is found once for all.
    steps = [0 if isinstance(step, int) else step for step in path]
    if len(steps) > 1 and steps[0] not in ONE_ENTRY:
        steps[1] = "*"
    return _unit_of(tuple(steps))


@lru_cache(maxsize=2_000)
def _unit_of(path: tuple[str | int, ...]) -> str | list[str] | None:
    node: Any = schema()
    for step in path:
        node = resolve(node)
        if isinstance(step, int):
            node = node.get("items")
        else:
            node = node.get("properties", {}).get(step, node.get("additionalProperties", node.get("items")))
        if not isinstance(node, dict):
            return None
    node = resolve(node)
    if node.get("type") not in ("number", "integer") and "x-unit" not in node:  # a number, or a list of them
        return None
    unit: str | list[str] = node.get("x-unit", "")
    return unit


def resolve(node: dict[str, Any]) -> dict[str, Any]:
    """Return what a fragment of the schema of descriptions refers to, or the fragment itself."""
    reference = node.get("$ref")
    return schema()["$defs"][reference.rsplit("/", 1)[1]] if reference else node
