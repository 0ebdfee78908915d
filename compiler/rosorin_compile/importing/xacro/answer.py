"""Answer with the program of a xacro as JSON: its body, macros, variables and formulas, for ``ir.build``.

This module runs in the child process.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from .child import portable
from .macro_calls import COMMENTS, MARK, Macro
from .symbols import TOKEN, as_printed, example_of, is_find, node_of

if TYPE_CHECKING:
    from .symbolic import Program


def answer_of(program: Program, document: Any) -> dict[str, Any]:
    """Return a run of a file as JSON: the document with its macros, and what was given up."""
    calls, defined = program.macro_calls, program.defined
    return {
        "name": document.documentElement.getAttribute("name"),
        "body": list(_nodes(program, document.documentElement)),
        "macros": [_macro(program, macro) for macro in calls.macros.values()],
        "tokens": [_source(as_printed(one)) for one in program.tokens],
        "variables": [_variable(program, one) for one in program.variables.values()],
        "inlined": [
            [*defined.get(key, (key, 0)), reason, key] for key, reason in program.inlined.items() if key in calls.called
        ],
        "silent": [defined[key][0] for key, has_made in calls.made.items() if not has_made and key in defined],
        "uncalled": [name for key, (name, _) in defined.items() if key not in calls.called],
        "defined": [[key, name, place] for key, (name, place) in defined.items()],
        "fixed": program.fixed,
        "reasons": program.inlined,
        "implicit": {key: sorted(names) for key, names in program.implicit.items()},
        "files": list(program.files),
        "loaded": program.chosen.loaded,
        "packages": {name: str(folder) for name, folder in program.packages.found()},
    }


def _source(node: ast.expr) -> str:
    return ast.unparse(ast.fix_missing_locations(node))


def _scalar(value: Any) -> Any:
    return value if isinstance(value, (str, int, float, bool)) else None


def _macro(program: Program, macro: Macro) -> dict[str, Any]:
    return {
        "key": macro.id,
        "name": macro.name,
        "level": macro.level,
        "parameters": macro.parameters,
        "body": list(_nodes(program, macro.body)),
        "place": getattr(macro.definition.body, MARK, None),
        "comments": getattr(macro.definition.body, COMMENTS, []),
    }


def _variable(program: Program, variable: dict[str, Any]) -> dict[str, Any]:
    value, candidates = variable["value"], program.candidates.get(variable["id"], [])
    shape = "list" if isinstance(value, (list, tuple)) else "table" if isinstance(value, dict) else ""
    formulas: dict[str, Any] = {name: _source(variable[name]) for name in ("node", "default") if name in variable}
    return {**variable, **formulas, "value": _scalar(value), "shape": shape, "candidates": candidates}


def _nodes(program: Program, parent: Any) -> Iterator[dict[str, Any]]:
    for node in parent.childNodes:
        if node.nodeType == node.COMMENT_NODE:
            yield {"comment": node.data}
        elif node.nodeType == node.TEXT_NODE:
            if node.data.strip():
                yield {"text": node.data.strip()}
        elif node.nodeType == node.ELEMENT_NODE:
            yield _element(program, node)


def _element(program: Program, node: Any) -> dict[str, Any]:
    place = getattr(node, MARK, None)
    made: dict[str, Any] = {"place": place, "comments": getattr(node, COMMENTS, [])}
    if node.tagName == "xacro-call":
        call = node.rosorin_call
        given = {name: [_source(node_of(value)), name in call.defaulted] for name, value in call.values.items()}
        examples = {name: _scalar(example_of(value)) for name, value in call.values.items()}
        return {**made, "call": node.getAttribute("macro"), "given": given, "examples": examples}
    if node.tagName == "xacro-if":
        test = int(TOKEN.fullmatch(node.getAttribute("test"))[1])  # type: ignore[index]
        return {**made, "test": test, "holds": node.getAttribute("holds") == "1", "body": list(_nodes(program, node))}
    attributes = dict(node.attributes.items())
    if "filename" in attributes and node.tagName in ("mesh", "texture"):
        attributes["filename"] = _portable(program, attributes["filename"])
    return {**made, "tag": node.tagName, "attributes": attributes, "body": list(_nodes(program, node))}


def _portable(program: Program, text: str) -> str:
    text = text.removeprefix("file://") if TOKEN.match(text.removeprefix("file://")) else text
    token = TOKEN.match(text)
    if token:
        node = program.tokens[int(token[1])].node
        if is_find(node):
            return f"package://{node.args[0].value}{text[token.end() :]}"  # type: ignore[attr-defined]
    return portable(text, program.packages, [*map(str, program.xacro.all_includes), program.file])
