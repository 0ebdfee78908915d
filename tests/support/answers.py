"""JSON output of commands, validated against the schema of the envelope."""

import json
from functools import cache

import jsonschema

from rosorin_compile.cli import console
from support.paths import SCHEMAS

_envelope = console.envelope


@cache
def _validator() -> jsonschema.Draft7Validator:
    return jsonschema.Draft7Validator(json.loads((SCHEMAS / "envelope.schema.json").read_text("utf-8")))


def held_envelope(answer: console.Console) -> dict[str, object]:
    """Return an answer as it is printed. Raises AssertionError if it does not match the schema."""
    made = _envelope(answer)
    wrong = [f"{list(one.path)}: {one.message[:200]}" for one in _validator().iter_errors(json.loads(json.dumps(made)))]
    assert wrong == []
    return made
