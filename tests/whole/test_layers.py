"""Modules of the core import only from the layers below their own."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from support.paths import PACKAGE

# From top to bottom.
LAYERS = (
    *("__main__", "cli", "commands", "backend", "pipeline", "meaning", "output", "formats", "rules", "frontend"),
    *("sections", "xml", "model", "plugins", "project", "diagnostics", "units", "numbers", "extending", "world"),
    *("shipped", "startup"),
)
# The folder of a section has modules that belong to other layers.
SECTION_MODULES = {"lowering": "frontend", "rules": "rules", "comparison": "meaning"}


def layer(module: str) -> str:
    """Return the layer of a module, given by its dotted name within the package."""
    top, *names = module.split(".")
    inner = [SECTION_MODULES[name] for name in names[1:] if name in SECTION_MODULES] if top == "sections" else []
    return inner[0] if inner else top or "__init__"


def imports(tree: ast.AST, package: list[str]) -> Iterator[tuple[int, str]]:
    """Yield the line and the dotted name of everything that a module imports from the core at run time."""
    if isinstance(tree, ast.If) and ast.unparse(tree.test) == "TYPE_CHECKING":
        return
    if isinstance(tree, ast.ImportFrom) and tree.level:
        origin = package[: len(package) - tree.level + 1] + (tree.module or "").split(".")
        for alias in tree.names:
            if alias.name != "__version__":
                yield tree.lineno, ".".join(filter(None, [*origin, alias.name]))
    for child in ast.iter_child_nodes(tree):
        yield from imports(child, package)


def test_modules_import_only_what_their_layer_may_import() -> None:
    wrong = []
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = list(path.relative_to(PACKAGE).with_suffix("").parts)
        package = parts[:-1]
        importer = layer(".".join(package if parts[-1] == "__init__" else parts))
        for line, name in imports(ast.parse(path.read_text("utf-8")), package):
            if importer in LAYERS and LAYERS.index(layer(name)) < LAYERS.index(importer):
                wrong.append(f"{path.relative_to(PACKAGE)}:{line}: {importer} may not import {name}")
    assert not wrong, "\n".join(wrong)
