"""Expressions reach nothing but values, and end. The guard of xacro's ``eval`` looks at the outermost code only."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.source.units import LENGTH, Quantity
from support.paths import DATA

pytestmark = pytest.mark.slow

NAMES: dict[str, Any] = {"radius": 0.5, "length": Quantity(0.5, LENGTH), "words": ["a", "b"], "text": "abc"}
NAMES |= {"table": {"a": 1}, "load()": lambda name: name}

ESCAPES = (DATA / "escapes.txt").read_text("utf-8").splitlines()
ESCAPES = [line for line in ESCAPES if not line.startswith("# ")]
LONG = {
    "parentheses": "(" * 5_000 + "1" + ")" * 5_000,
    "signs": "-" * 1_500 + "1",
    "terms": "1" + "+1" * 900,
    "brackets": "[" * 1_900,
    "powers": "1" + "**1" * 600,
    "choices": "1 if 1 else " * 150 + "1",
    "a text": f"'{'x' * 10**6}'",
    "a number": "9" * 1_900,
    "NUL": "1\0",
    "half a letter": "'\ud800' + 1",
}


@pytest.mark.parametrize("escape", [*ESCAPES, *(pytest.param(text, id=name) for name, text in LONG.items())])
def test_expression_does_not_escape(escape: str) -> None:
    with pytest.raises(ExpressionError) as raised:
        evaluate(escape, NAMES.__getitem__)
    assert raised.value.message
    assert not re.search(r"<[a-z_. ]+ at 0x|Traceback", raised.value.message)
