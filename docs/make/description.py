"""The schema of descriptions as it is committed: the pieces in the folders of the sections, in one file.

    python docs/make/description.py > schemas/description.schema.json

``python tests/renew.py schema`` does that too. The schema.json of ``language/sections`` names the piece of each section
and has what several sections use; definitions of a section are in its piece.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2] / "compiler/rosorin_compile/language/sections/schema.json"


def text() -> str:
    """Return the schema of descriptions as it is committed. Raises ValueError if two pieces define one name."""
    schema = _read(ROOT)
    sections, definitions = schema["properties"], schema["$defs"]
    for name, section in sections.items():
        if section.get("$ref", "").endswith(".json"):
            sections[name] = piece = _read(ROOT.parent / section["$ref"])
            added = piece.pop("$defs", {})
            if duplicates := added.keys() & definitions.keys():
                raise ValueError(f"{section['$ref']} defines {', '.join(sorted(duplicates))} again")
            definitions |= added
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def _read(path: Path) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return made


if __name__ == "__main__":
    sys.stdout.write(text())
