"""The authoring schema as it is committed: the schema of descriptions as they are written, for editors.

    python docs/make/authoring.py > schemas/authoring.schema.json

``python tests/renew.py schema`` does that too.
"""

from __future__ import annotations

import json
import sys

from rosorin_compile.formats import FORMATS
from rosorin_compile.language.authoring import authoring_schema


def text() -> str:
    """Return the authoring schema as it is committed."""
    return json.dumps(authoring_schema(FORMATS.values()), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    sys.stdout.write(text())
