"""The robots of every_word/ use every word of the language: a new one fails here until one of them says it.

That they are free of errors is what test_goldens.py asserts, which has an artifact of each.
"""

from __future__ import annotations

from pathlib import Path

import yaml

from rosorin_compile.language.schema import schema
from support.words import used, words

SCHEMA = schema()
HERE = Path(__file__).parent
WRITTEN = {file.name: yaml.safe_load(file.read_text("utf-8")) for file in sorted((HERE / "every_word").glob("*.yaml"))}


def test_every_word_is_used() -> None:
    said = {word for written in WRITTEN.values() for word in used(SCHEMA, written)}
    assert sorted(words(SCHEMA) - said) == []


def test_every_file_is_of_a_robot_whose_artifacts_are_kept() -> None:
    """Or its words would count, and nothing would compile them."""
    robots = {name: written for name, written in WRITTEN.items() if "robot" in written}
    digests = (HERE / "digests.txt").read_text("utf-8")
    assert [name for name in robots if f"tests/judges/goldens/every_word/{name}: " not in digests] == []
    included = {name for written in robots.values() for name in written.get("include", ())}
    assert set(WRITTEN) - set(robots) == included
