"""Patterns of ours behave as those of the library, which a type checker takes them for."""

from __future__ import annotations

import re
import subprocess
import sys
import threading

import pytest

from rosorin_compile.startup import patterns

TEXT = "one = 1, Two = 22"


@pytest.mark.parametrize("flags", [0, re.IGNORECASE])
def test_a_pattern_answers_as_that_of_the_library(flags: int) -> None:
    ours, theirs = patterns.compile(r"(?P<name>t\w+) = (\d+)", flags), re.compile(r"(?P<name>t\w+) = (\d+)", flags)
    assert ours.findall(TEXT) == theirs.findall(TEXT)
    assert ours.sub("x", TEXT) == theirs.sub("x", TEXT)
    assert bool(ours.search(TEXT)) == bool(theirs.search(TEXT))
    assert (ours.pattern, ours.flags, ours.groups, ours.groupindex) == (
        *(theirs.pattern, theirs.flags, theirs.groups),
        theirs.groupindex,
    )


def test_a_wrong_pattern_is_told_when_it_is_used() -> None:
    ours = patterns.compile("(")
    with pytest.raises(re.error):
        ours.search(TEXT)
    with pytest.raises(AttributeError):
        patterns.compile("a").finds  # type: ignore[attr-defined]  # noqa: B018


def test_yaml_is_whole_all_the_same() -> None:
    """What is imported with patterns that come later still works, and nothing else gets such."""
    code = """
import re
from rosorin_compile.frontend import load
assert type(re.compile("a")) is re.Pattern
import yaml
for Loader in (yaml.SafeLoader, yaml.CSafeLoader):
    assert yaml.load("a: 2001-01-01\\nb: 12:30:00\\nc: 1_000\\nd: on\\n", Loader) == yaml.load(
        "{a: !!timestamp 2001-01-01, b: 45000, c: 1000, d: true}", Loader)
    try:
        yaml.load("a: \\x07", Loader)
    except yaml.reader.ReaderError:
        print("refused")
print(yaml.safe_dump({"a": "2001-01-01", "b": "x: y"}))
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "refused\nrefused\na: '2001-01-01'\nb: 'x: y'\n\n"


def test_other_threads_compile_as_ever() -> None:
    found: list[object] = []
    with patterns.compiled_later():
        other = threading.Thread(target=lambda: found.append(re.compile("a")))
        other.start()
        other.join()
        found.append(re.compile("a"))
    assert [type(one) is re.Pattern for one in found] == [True, False]
