"""The pages and the schema that docs/make generates are as it generates them; nothing that is shipped knows it."""

import subprocess
import sys
from pathlib import Path

import pytest

from support.generated import GENERATED, generated, language_pages
from support.paths import DOCS, ROOT

GENERATORS = DOCS / "make"


@pytest.mark.parametrize("path", GENERATED, ids=lambda path: path.name)
def test_what_is_committed_is_what_the_generator_gives(path: Path) -> None:
    what = "schema" if path.suffix == ".json" else "docs"
    assert path.read_text("utf-8") == generated(path), f"python tests/renew.py {what}"


def test_the_pages_of_the_language_are_those_of_the_schema() -> None:
    files = [DOCS / "language.md", *(DOCS / "language").iterdir()]
    assert {path: path.read_text("utf-8") for path in files} == language_pages(), "python tests/renew.py docs"


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
