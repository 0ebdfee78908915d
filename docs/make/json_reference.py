"""The page of what commands answer as JSON, made from the schemas of their answers.

    python docs/make/json_reference.py > docs/json.md

``python tests/renew.py docs`` does that too, after ``python tests/renew.py schema``, which makes those schemas from
the types of results. What is said of all answers stands in ``docs/_json_head.md``.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1]
HEAD = DOCS / "_json_head.md"
SCHEMAS = DOCS.parent / "schemas"
_TITLE = "What rosorin-compile ", " answers"


def text() -> str:
    """Return the page: what each result is, and each kind of object once."""
    shown: set[str] = set()
    every = _schema("answer")
    lines = [HEAD.read_text("utf-8").rstrip(), *_definitions(every["definitions"], shown)]
    for whole in sorted(map(_schema, _names()), key=_command):
        result, _ = whole["properties"]["result"]["anyOf"]
        lines += ["", f"## {_command(whole)}", "", f"`{whole['$id']}`; the result is {_type(result)}."]
        lines += _definitions(whole["definitions"], shown)
    return "\n".join(lines) + "\n"


def _names() -> Iterator[str]:
    """Yield the names of the schemas of single commands."""
    ending = ".schema.json"
    yield from (path.name.removesuffix(ending) for path in SCHEMAS.glob(f"answer_*{ending}"))


def _schema(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((SCHEMAS / f"{name}.schema.json").read_text("utf-8"))
    return found


def _command(whole: Mapping[str, Any]) -> str:
    """Return the words that call the command whose answers a schema describes."""
    before, after = _TITLE
    title: str = whole["title"]
    return title.removeprefix(before).removesuffix(after)


def _definitions(definitions: Mapping[str, Any], shown: set[str]) -> Iterator[str]:
    """Yield a table for each kind of object that has none yet."""
    for name, node in definitions.items():
        if name in shown:
            continue
        shown.add(name)
        yield from ("", f"### {name}", "", node["description"], "", "| key | meaning | type |", "|---|---|---|")
        for key, inner in node["properties"].items():
            often = "" if key in node["required"] else "not always; "
            about = (often + inner.get("description", "")).removesuffix("; ").replace("|", "\\|")
            yield f"| `{key}` |{f' {about} ' if about else ' '}| {_type(inner)} |"


def _type(node: Mapping[str, Any]) -> str:
    """Return what a value is, in words; a kind of object leads to its table."""
    (node,) = node.get("allOf", [node])
    if "$ref" in node:
        name = node["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "anyOf" in node:
        return " or ".join(map(_type, node["anyOf"]))
    if "enum" in node:
        return ", ".join(f"`{one}`" for one in node["enum"])
    kind = node.get("type", "any value")
    if kind == "array":
        return f"list of {_type(node['items'])}"
    if kind == "object":
        return f"object: name to {_type(node['additionalProperties'])}"
    return " or ".join(kind) if isinstance(kind, list) else kind


if __name__ == "__main__":
    sys.stdout.write(text())
