"""A tree from the cache is the tree of the file: values, kinds, places, what is one value, how it came there."""

from __future__ import annotations

import marshal
import os
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile import compile as compile_robot
from rosorin_compile.diagnostics import Source, Span
from rosorin_compile.frontend import cached_trees
from rosorin_compile.frontend.cached_trees import CachedTrees
from rosorin_compile.frontend.load import LoadError, load_mapping, parse_yaml
from rosorin_compile.frontend.tree import Instance, Map, Seq
from rosorin_compile.startup.cache import keep, private_folder, recalled
from rosorin_compile.units import Quantity

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted(
    path
    for folder in ("descriptions", "examples", "parts", "tests/data", "tests/bad", "tests/imported")
    for path in (ROOT / folder).rglob("*.yaml")
)


@pytest.fixture(autouse=True)
def at_home(home: Path) -> Path:
    """A folder and a cache that are empty."""
    return home


def facts(value: Any, seen: dict[int, int]) -> Any:
    """Return all that there is to know of a value; one that was seen before is its number."""
    kind = type(value).__name__
    if isinstance(value, (Map, Seq)):
        if id(value) in seen:
            return seen[id(value)]
        seen[id(value)] = len(seen)
        spans = [value.span, value.value_spans, value.key_spans if isinstance(value, Map) else None]
        inner = list(value.items()) if isinstance(value, Map) else list(enumerate(value))
        return kind, spans, value.via, [(key, type(key).__name__, facts(one, seen)) for key, one in inner]
    if isinstance(value, Quantity):
        return kind, float(value).hex(), value.dimension, value.text
    return kind, repr(value)


def again(path: Path, via: Instance | None = None) -> tuple[Map, bool]:
    """Return a file that was read and kept, as another run has it; and whether nothing was parsed for that."""
    first = CachedTrees(path)
    first.mapping(path, path.name, None, None)
    first.keep()
    parsed: list[Path] = []
    with pytest.MonkeyPatch.context() as patch:
        own = cached_trees.mapping_of
        patch.setattr(cached_trees, "mapping_of", lambda *given: (parsed.append(path), own(*given))[1])
        return CachedTrees(path).mapping(path, path.name, None, via), not parsed


def test_files_of_the_repository() -> None:
    kept = 0
    for path in FILES:
        try:
            fresh = load_mapping(path, path.name)
        except LoadError:
            continue
        tree, unparsed = again(path)
        assert facts(tree, {}) == facts(fresh, {}), path
        assert unparsed, path
        kept += 1
    assert kept > 300


SCALARS = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["12.5 mm", "3 deg/s", "on", "0x1F", "1_0", "!", "&a", "*a", "${x}", "$${x}", " x ", "é🤖"])
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4)
)


@settings(max_examples=200, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.dictionaries(st.text(max_size=5), VALUES, max_size=5), st.booleans(), st.sampled_from([None, '"', "'", "|"]))
def test_anything(at_home: Path, value: dict[str, Any], flow: bool, style: str | None) -> None:
    text = yaml.safe_dump(value, default_flow_style=flow, default_style=style, allow_unicode=True)
    path = at_home / "robot.yaml"
    path.write_text(text, "utf-8", newline="")
    try:
        fresh = load_mapping(path, path.name)
    except LoadError:  # what the file may not hold
        return
    tree, unparsed = again(path)
    assert facts(tree, {}) == facts(fresh, {})
    assert unparsed


def test_what_an_anchor_names_stays_one(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: &x {b: [1, 2]}\nc: *x\nd: [*x, *x]\n")
    tree, unparsed = again(path)
    assert unparsed
    assert tree["a"] is tree["c"] is tree["d"][0] is tree["d"][1]


def test_aliases_that_multiply_take_no_more_than_they_did(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    steps = [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 6)]
    path.write_text("\n".join(["a0: &a0 [1, 2, 3]", *steps]) + "\n")
    _, unparsed = again(path)
    assert unparsed
    [file] = Path(private_folder("trees")).iterdir()
    assert file.stat().st_size < 5_000


def test_how_it_came_there_is_told_anew(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: {b: [1, {c: 2}]}\n")
    via = Instance("included here", Span(Source("above.yaml", "include: robot.yaml\n"), 1, 10, 10))
    tree, unparsed = again(path, via)
    assert unparsed
    assert tree.via is tree["a"].via is tree["a"]["b"].via is tree["a"]["b"][1].via is via


def test_another_text_is_read(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: 1 mm\n")
    assert again(path)[1]
    status = path.stat()
    path.write_text("a: 2 mm\n")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert CachedTrees(path).mapping(path, path.name) == {"a": 0.002}


def test_the_name_that_is_shown_is_that_of_now(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: 1\n")
    trees = CachedTrees(path)
    trees.mapping(path, "robot.yaml")
    trees.keep()
    assert CachedTrees(path).mapping(path, "../robot.yaml").span.source.path == "../robot.yaml"


@pytest.mark.parametrize(
    "data", [5, [], {"robot.yaml": 3}, {"robot.yaml": ("a: 1\n", b"")}, {"robot.yaml": ("a: 1\n", b"i")}]
)
def test_what_is_damaged_is_read(at_home: Path, data: object) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: 1\n")
    again(path)
    [file] = Path(private_folder("trees")).iterdir()
    keep(file, marshal.dumps(data))
    assert recalled(file) is not None
    assert again(path) == ({"a": 1}, True)


def test_it_is_of_the_modules_that_read_it(at_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = at_home / "robot.yaml"
    path.write_text("a: 1\n")
    before = CachedTrees(path)._file
    monkeypatch.setattr(cached_trees, "_meaning", lambda: "another")
    assert CachedTrees(path)._file not in ("", before)


def test_without_a_cache(at_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", "off")
    path = at_home / "robot.yaml"
    path.write_text("a: 1\n")
    assert again(path) == ({"a": 1}, False)


def test_a_robot_is_the_same_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    first = ROOT / "descriptions" / "rosorin" / "robot.yaml"
    cold, warm = compile_robot(first), compile_robot(first)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", "off")
    without = compile_robot(first)
    assert cold.robot == warm.robot == without.robot
    assert cold.artifacts == warm.artifacts == without.artifacts
    assert cold.diagnostics == warm.diagnostics == without.diagnostics


def test_a_text_of_lists_is_no_mapping(at_home: Path) -> None:
    path = at_home / "robot.yaml"
    path.write_text("- 1\n")
    for _ in range(2):
        with pytest.raises(LoadError):
            CachedTrees(path).mapping(path, path.name)
    assert isinstance(parse_yaml(Source("robot.yaml", "- 1\n")), Seq)


def test_so_many_files_are_not_kept_that_nobody_has_room(at_home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cached_trees, "_MOST", 20)
    monkeypatch.setattr(cached_trees, "_MOST_OF_ALL", 30)
    sizes = {"a.yaml": 15, "b.yaml": 25, "c.yaml": 5, "d.yaml": 15, "e.yaml": 10}
    for name, size in sizes.items():
        (at_home / name).write_text(f"{name[0]}: 1".ljust(size))
    for _ in range(2):
        trees = CachedTrees(at_home / "a.yaml")
        for name in sizes:
            assert list(trees.mapping(at_home / name, name)) == [name[0]]
        kept = set(trees._used)
        trees.keep()
    assert kept == {"a.yaml", "c.yaml", "e.yaml"}
