"""What a benchmark imports of the tool is there: nobody else runs most of them."""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from support.paths import PACKAGE, ROOT

BENCHMARKS = sorted((ROOT / "benchmarks").glob("*.py"))


@pytest.mark.parametrize("path", BENCHMARKS, ids=lambda path: path.stem)
def test_what_it_imports_is_there(path: Path) -> None:
    nodes = [node for node in ast.walk(ast.parse(path.read_text("utf-8"))) if isinstance(node, ast.ImportFrom)]
    taken = [(node.module or "", one.name) for node in nodes for one in node.names]
    ours = [(module, name) for module, name in taken if module.partition(".")[0].startswith(PACKAGE.name)]
    assert [
        f"{module}.{name}"
        for module, name in ours
        if not hasattr(import_module(module), name) and find_spec(f"{module}.{name}") is None
    ] == []
