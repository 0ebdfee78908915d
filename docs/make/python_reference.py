"""The page of the Python API, made from the docstrings of its functions and results.

    python docs/make/python_reference.py > docs/python.md

``python tests/renew.py docs`` does that too. What docstrings do not say is in ``docs/_python_head.md``.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import rosorin_compile
from rosorin_compile import extend, model

HEAD = Path(__file__).parents[1] / "_python_head.md"
_SECTION = re.compile(r"(Args|Returns|Yields|Raises|Example):")
_SKIPPED = "  # doctest: +SKIP"


def text() -> str:
    """Return the page: the functions, their results, and the names that are public beside them."""
    public = [getattr(rosorin_compile, name) for name in rosorin_compile.__all__ if not name.startswith("_")]
    functions = [one for one in public if inspect.isfunction(one)]
    classes = [one for one in public if inspect.isclass(one)]
    lines = [HEAD.read_text("utf-8").rstrip(), "", "## Functions"]
    for function in sorted(functions, key=lambda one: one.__name__):
        lines += ["", f"### {function.__name__}", "", *_signature(function), "", *_body(function)]
    lines += ["", "## Results"]
    for kind in sorted(classes, key=lambda one: one.__name__):
        lines += ["", f"### {kind.__name__}", "", *_body(kind), *_fields(kind)]
    lines += ["", "## Other public modules", "", "| module | names |", "|---|---|"]
    for module, about in (
        (model, "the parts of a robot, as frozen dataclasses"),
        (extend, "for [plug-ins](extend.md)"),
    ):
        names = ", ".join(f"`{name}`" for name in sorted(module.__all__))
        lines.append(f"| `{module.__name__}` | {about}: {names} |")
    lines += ["", "Names that are not listed here can change in any release."]
    return "\n".join(lines) + "\n"


def _signature(function: object) -> Iterator[str]:
    """Yield the signature without types, with a star before keyword-only parameters."""
    parameters = inspect.signature(function).parameters.values()  # type: ignore[arg-type]
    shown, keyword = [], False
    for one in parameters:
        if one.kind is one.KEYWORD_ONLY and not keyword:
            shown.append("*")
            keyword = True
        shown.append(one.name if one.default is one.empty else f"{one.name}={one.default!r}")
    yield from ("```text", f"{function.__name__}({', '.join(shown)})", "```")  # type: ignore[attr-defined]


def _body(documented: object) -> Iterator[str]:
    """Yield a docstring as Markdown: its sections as lists, its example as a block."""
    section = ""
    block: list[str] = []
    for line in [*(inspect.getdoc(documented) or "").splitlines(), "Example:"]:
        if _SECTION.fullmatch(line):
            yield from _rendered(section, block)
            section, block = line.removesuffix(":"), []
        else:
            block.append(line)


def _rendered(section: str, block: list[str]) -> Iterator[str]:
    lines = inspect.cleandoc("\n".join(["", *block])).splitlines()
    if not lines:
        return
    if not section:
        yield from (line.replace("``", "`") for line in lines)
    elif section == "Example":
        plain = any(_SKIPPED in line for line in lines)
        yield from ("", "```python")
        for line in (line for line in lines if not plain or line.startswith((">>>", "..."))):
            yield line.removesuffix(_SKIPPED).removeprefix(">>> " if plain else "").rstrip()
        yield "```"
    elif section in ("Returns", "Yields"):
        yield from ("", f"{section}: {' '.join(lines).replace('``', '`')}")
    else:
        yield from ("", {"Args": "Parameters:"}.get(section, f"{section}:"), "")
        for entry in _entries(lines):
            name, _, about = entry.partition(": ")
            yield f"- `{name}`: {about}"


def _entries(lines: list[str]) -> list[str]:
    """Return the entries of a section, an indented line belonging to the entry before."""
    found: list[str] = []
    for line in lines:
        if line.startswith(" ") and found:
            found[-1] += f" {line.strip()}"
        else:
            found.append(line.strip())
    return [one.replace("``", "`") for one in found]


def _fields(kind: type) -> Iterator[str]:
    """Yield the fields of a dataclass with their types."""
    if not dataclasses.is_dataclass(kind):
        return
    fields = [f"`{field.name}`" for field in dataclasses.fields(kind)]
    made = [f"`{name}`" for name, value in vars(kind).items() if isinstance(value, property) and name[0] != "_"]
    if fields:
        yield from ("", f"Fields: {', '.join(fields)}." + (f" Properties: {', '.join(made)}." if made else ""))


if __name__ == "__main__":
    sys.stdout.write(text())
