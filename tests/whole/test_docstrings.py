"""The examples in the documentation of functions say what the functions return."""

import doctest
import importlib

import pytest

from support.paths import COMPILER, PACKAGES

WITH_EXAMPLES = [
    ".".join(path.relative_to(COMPILER).with_suffix("").parts)
    for path in sorted(path for package in PACKAGES for path in package.rglob("*.py"))
    if ">>> " in path.read_text("utf-8")
]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_what_the_examples_say(name: str) -> None:
    failed, tried = doctest.testmod(importlib.import_module(name))
    assert tried
    assert not failed
