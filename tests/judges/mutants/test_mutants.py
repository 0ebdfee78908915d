"""What the tier of mutants relies on: known survivors are mutants, tests are chosen well, coverage is kept."""

from __future__ import annotations

import ast
import random
from collections import Counter
from pathlib import Path

import pytest

from judges.mutants import forgetting, line_coverage, running
from judges.mutants.drawing import Mutant, modules, mutants
from judges.mutants.line_coverage import Room
from judges.mutants.running import (
    JUDGES,
    LEAST,
    LONGEST,
    MOST,
    PART,
    SURVIVES,
    Answers,
    asked_of,
    import_lines,
    others_of,
    survivors,
    with_imports,
)
from rosorin_compile.frontend.annotations import sections
from support.paths import COMPILER


def test_each_known_survivor_is_a_mutant_of_today_and_has_a_reason() -> None:
    known = survivors()
    of = {name.partition(": ")[0] for name in known}
    paths = {path.relative_to(COMPILER).as_posix(): path for path in modules(COMPILER)}
    made = {one.name for name in of if name in paths for one in mutants(paths[name].read_text("utf-8"), name)}
    assert [name for name in known if name not in made] == []
    assert [name for name, reason in known.items() if not reason] == []


def test_what_saw_a_mutant_is_kept_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "DRAWN", tmp_path / "drawn.txt")
    test = "tests/test_b.py::test_x[1-a\\tb # c]"
    running.write_drawn([("b.py: x", test), ("a.py: gone # y", ""), ("c.py: z", SURVIVES)])
    assert running.drawn_before() == [("a.py: gone # y", ""), ("b.py: x", test), ("c.py: z", "")]


def test_an_answer_is_kept_for_a_module_as_it_is(tmp_path: Path) -> None:
    one = Mutant("a.py", 3, "number", "0", "1", "x = 1\n", "f: x = 0")
    Answers(tmp_path / "kept").add(one, "tests/test_a.py::test_x")
    again = Answers(tmp_path / "kept")
    assert again.before(one) == "tests/test_a.py::test_x"
    assert again.before(one._replace(text="y = 2\nx = 1\n")) is None


def test_a_mutant_is_one_change_that_python_reads() -> None:
    text = "def f(a, b):\n    if a < b and not a:\n        return -1.5\n    f(b, 0)\n    return a + b\n"
    found = list(mutants(text, "m.py"))
    kinds = {"comparison": 1, "boolean": 2, "sign": 2, "number": 2, "return": 2, "dropped": 1}
    assert Counter(one.kind for one in found) == kinds
    for one in found:
        assert ast.dump(ast.parse(one.text)) != ast.dump(ast.parse(text))
        pairs = zip(text.split("\n"), one.text.split("\n"), strict=True)
        differing = [number for number, (before, after) in enumerate(pairs, 1) if before != after]
        assert differing == [one.line]


def test_the_tests_that_are_asked_come_to_each_line_of_the_module() -> None:
    many = [*(f"t{number}" for number in range(500)), "a.py::t", "a.py::u", "b.py::t"]
    lines = {0: ["alone"], 1: many, 2: ["t7"], 3: ["t8", "alone"], 4: ["t7", "t9", "broken"]}
    lines |= {5: ["a.py::t", "b.py::t", "a.py::u"]}
    some = asked_of(lines, 1, {}, {"broken"}, random.Random(1))  # noqa: S311
    assert len(some) == len(set(some)) == MOST
    assert {"t7", "t8", "b.py::t"} <= set(some) <= set(many)
    assert {"a.py::t", "a.py::u"} & set(some)
    assert sorted(asked_of(lines, 4, {}, {"broken"}, random.Random(1))) == ["t7", "t9"]  # noqa: S311


def test_of_what_the_import_of_a_module_runs_all_its_tests_are_asked() -> None:
    head = "A = 1\n@cache\ndef f(\n    a=2,\n):\n    return a\n"
    text = f"{head}class C:\n    b: int = 3\n    def g(self):\n        return A\n"
    assert import_lines(text) == {1, 2, 3, 4, 5, 7, 8, 9, 11}
    module = "rosorin_compile/frontend/expand/mirroring.py"
    at_top = import_lines((COMPILER / module).read_text("utf-8"))
    inside = min(set(range(1, max(at_top))) - at_top)
    found = with_imports({module: {inside: ["t1"], inside + 1: ["t2"]}, "gone.py": {1: ["t3"]}})
    assert all(found[module][line] == ["t1", "t2"] for line in at_top)
    assert (found[module][inside], found["gone.py"]) == (["t1"], {1: ["t3"]})


def test_the_quickest_tests_are_asked_and_no_more_than_take_their_time() -> None:
    many = [f"t{number}" for number in range(500)]
    lines = {0: ["first"], 1: [*many, "a.py::slow", "a.py::quick"], 2: ["a.py::slow", "a.py::quick"]}
    seconds = {**dict.fromkeys(many, 0.2), "a.py::slow": 2.0, "a.py::quick": 0.1}
    some = asked_of(lines, 1, seconds, (), random.Random(1))  # noqa: S311
    assert some[0] == "a.py::quick"
    assert "a.py::slow" not in some
    assert LONGEST - 0.2 <= sum(seconds[test] for test in some) <= LONGEST
    assert len(asked_of(lines, 1, dict.fromkeys(lines[1], 9.0), (), random.Random(1))) == LEAST  # noqa: S311
    assert asked_of(lines, 2, {"a.py::slow": 9.0}, (), random.Random(1)) == ["a.py::quick"]  # noqa: S311


def test_a_test_runs_what_another_has_asked_before() -> None:
    sections()
    forgetting.forget()
    assert sections.cache_info().currsize == 0


def test_what_survives_is_asked_of_all_others_the_quickest_first() -> None:
    many = [f"t{number}" for number in range(100)]
    seconds = {test: 0.1 * number for number, test in enumerate(many)} | {"t3": 2 * PART}
    lines = {0: ["first"], 1: [*many, "broken", "asked"], 2: ["elsewhere"]}
    parts = list(others_of(lines, 1, seconds, {"broken", "asked"}))
    assert [test for part in parts for test in part] == [*many[:3], *many[4:], "t3"]
    assert all(sum(seconds[test] for test in part) <= PART for part in parts[:-1])
    assert parts[-1] == ["t3"]
    judges = [f"{JUDGES}test_planted.py::test_{word}" for word in "ab"]
    parts = list(others_of({1: [*many, *judges]}, 1, {**seconds, judges[0]: 1.0}, ()))
    assert [test for part in parts[:2] for test in part][-2:] == [judges[1], judges[0]]
    assert len(parts[1]) == 2
    assert list(others_of(lines, 2, seconds, {"elsewhere"})) == list(others_of(lines, 3, seconds, ())) == []


def test_coverage_is_kept_as_it_is_written() -> None:
    kept = line_coverage.KEPT.read_text("utf-8")
    assert {"formats", "meaning", "rules"} <= line_coverage.kept(kept).keys()
    assert line_coverage.text(line_coverage.kept(kept)) == kept


@pytest.mark.parametrize(
    ("run", "said"),
    [(950, []), (946, []), (944, ["model: quick tests run 94.4 % of its lines, 95.0 % before"]), (990, [])],
)
def test_fewer_lines_are_told(run: int, said: list[str]) -> None:
    before = {"model": Room(1000, 950), "gone": Room(10, 10)}
    assert list(line_coverage.fewer(before, {"model": Room(1000, run)})) == said


def test_a_room_without_a_figure_is_told() -> None:
    said = ["fresh: quick tests run 50.0 % of its lines, and no figure is kept: --coverage"]
    assert list(line_coverage.fewer({}, {"fresh": Room(10, 5)})) == said
