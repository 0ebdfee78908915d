"""The pages and the schema that docs/make generates are as it generates them; nothing that is shipped knows it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from support.generated import GENERATED, generated, schemas_of_answers
from support.paths import COMPILER, DOCS, ROOT, SCHEMAS

GENERATORS = DOCS / "make"


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_what_is_committed_is_what_the_generator_gives(path: Path) -> None:
    what = "schema" if path.suffix == ".json" else "docs"
    assert path.read_text("utf-8") == generated(path), f"python tests/renew.py {what}"


def test_the_schemas_of_answers_are_those_of_their_types() -> None:
    committed = {path: path.read_text("utf-8") for path in SCHEMAS.glob("answer*.schema.json")}
    assert committed == schemas_of_answers(), "python tests/renew.py schema"


@pytest.mark.slow
@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_a_generator_runs_as_its_first_lines_say(path: Path, tmp_path: Path) -> None:
    program = GENERATORS / f"{GENERATED[path]}.py"
    documented = f"    python {program.relative_to(ROOT)} > {path.relative_to(ROOT)}\n"
    assert documented in program.read_text("utf-8")
    for folder in (ROOT, tmp_path):
        ran = subprocess.run([sys.executable, program], cwd=folder, capture_output=True, check=True)
        assert ran.stdout == path.read_bytes()
        assert not ran.stderr


def test_every_generator_makes_something_or_is_imported_by_one_that_does() -> None:
    names = {path.stem for path in GENERATORS.glob("*.py")}
    texts = [(GENERATORS / f"{name}.py").read_text("utf-8") for name in GENERATED.values()]
    helpers = {name for name in names for text in texts if f"from {name} import" in text}
    assert names == {*GENERATED.values(), *helpers}


def test_nothing_that_is_shipped_knows_a_generator() -> None:
    shipped = "".join(path.read_text("utf-8") for path in COMPILER.rglob("*.py"))
    assert not [name for name in GENERATED.values() if f"import {name}" in shipped or f"docs/make/{name}" in shipped]
