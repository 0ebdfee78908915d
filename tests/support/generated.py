"""What is committed and made by the generators in docs/make.

    python tests/renew.py docs
    python tests/renew.py schema

write it anew: the first the pages, along with what commands print on all others, the second the schemas.
"""

from importlib import import_module
from pathlib import Path

from support.paths import DOCS, SCHEMAS

# Each file and the module of docs/make whose ``text()`` it is; the pages of the language are made together.
GENERATED = {
    DOCS / "rules.md": "rules_reference",
    DOCS / "parts-library.md": "library_reference",
    DOCS / "python.md": "python_reference",
    SCHEMAS / "description.schema.json": "description",
    SCHEMAS / "authoring.schema.json": "authoring",
}


def language_pages() -> dict[Path, str]:
    """Return the page of the language and the page of each of its sections, by their files."""
    pages: dict[str, str] = import_module("reference").pages()
    return {DOCS / name: text for name, text in pages.items()}


def generated(path: Path) -> str:
    """Return what a file has to be."""
    text: str = import_module(GENERATED[path]).text()
    return text


def generate(path: Path) -> None:
    path.write_text(generated(path), "utf-8")


if __name__ == "__main__":
    for path in GENERATED:
        if path.parent == SCHEMAS:
            generate(path)
