"""Nothing that a person can write ends in a traceback, hangs or grows without bound; it is told with its place."""

import json
import os
import random
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.language.expression import evaluate
from rosorin_compile.language.expression.functions import CONSTANTS, FUNCTIONS, ExpressionError
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.units import LENGTH, Quantity
from support.fuzzing import held, with_a_mistake
from support.paths import DATA, TESTS, data_text

pytestmark = pytest.mark.slow

SECONDS, MEGABYTES = 20, 1_000

ROBOT = "robot: bomb\nlinks:\n  base_link: {}\n"


def write(files: dict[str, str | bytes], folder: Path) -> None:
    for name, data in files.items():
        (folder / name).write_bytes(data.encode("utf-8") if isinstance(data, str) else data)


def lets(*pairs: tuple[str, str]) -> str:
    return f"{ROBOT}let:\n" + "".join(f"  {name}: {value}\n" for name, value in pairs)


def doubled(first: str, following: str, times: int = 60) -> str:
    """Named values, each made of the one before twice: ``following`` has {0} for its name."""
    return lets(("a0", first), *((f"a{n + 1}", following.format(f"a{n}")) for n in range(times)))


def nested(levels: int, last: str) -> str:
    parts = "".join(f"  p{n}: {{use: {{x: {{part: p{n + 1}}}, y: {{part: p{n + 1}}}}}}}\n" for n in range(levels))
    return f"{ROBOT}parts:\n{parts}  p{levels}: {last}\nuse: {{u: {{part: p0}}}}\n"


def comprehension(item: str) -> str:
    letters = ("letters", "${join('', ['aaaaaaaaaa' for i in range(9999)])}")
    return lets(("many", "${range(100000)}"), letters, ("x", f"${{[{item} for i in range(100000)]}}"))


ALIASES = lets(("a0", "&a0 [1]"), *((f"a{n}", f"&a{n} [*a{n - 1}, *a{n - 1}]") for n in range(1, 60)))

# What grows, and the rule that stops it; without a rule it has to end well.
BOMBS = {
    "text-doubled": (doubled("aaaaaaaa", "${{{0} + {0}}}"), "expression"),
    "text-joined": (doubled("aaaaaaaa", '"${{{0}}}${{{0}}}"'), "expression"),
    "list-doubled": (doubled("[1, 2]", "${{{0} + {0}}}"), "expression"),
    "list-of-lists": (doubled("[1, 2]", "${{[{0}, {0}]}}"), "expression"),
    "list-written": (doubled("[1, 2]", '["${{{0}}}", "${{{0}}}"]'), "expression"),
    "table-written": (doubled("[1, 2]", '{{x: "${{{0}}}", y: "${{{0}}}"}}'), "expression"),
    "digits-doubled": (doubled("${[9**60]}", "${{[{0}[0] * {0}[0]]}}"), "expression"),
    "power": (lets(("x", "${9**9**9}")), "expression"),
    "heavy-ranges": (comprehension("range(100000)"), "expression"),
    "heavy-texts": (comprehension("letters + 'b'"), "expression"),
    "heavy-slices": (comprehension("many[:]"), "expression"),
    "heavy-sorts": (comprehension("sorted(many)"), "expression"),
    "heavy-searches": (comprehension("-1 in many"), "expression"),
    "heavy-sums": (comprehension("sum(many)"), "expression"),
    "heavy-comparisons": (comprehension("many == many"), "expression"),
    "heavy-capitals": (comprehension("upper(letters)"), "expression"),
    "loops-in-loops": (comprehension("[j for j in many for k in many]"), "expression"),
    "range": (f'{ROBOT}  "l${{i}}": {{for: {{i: "${{range(10**9)}}"}}}}\n', "expression"),
    "product": (f'{ROBOT}  "l${{i}}": {{for: {{i: "${{range(10000)}}", j: "${{range(10000)}}"}}}}\n', "too-large"),
    "parts-22": (nested(22, "{links: {l: {}}}"), "too-large"),
    "parts-60": (nested(60, "{links: {l: {}}}"), "part-cycle"),
    "part-of-itself": (nested(1, "{use: {x: {part: p0}, y: {part: p0}, z: {part: p1}}}"), "part-cycle"),
    "aliases": (ALIASES, "yaml-too-large"),
    "brackets": (lets(("x", "[" * 5_000 + "]" * 5_000)), "yaml-too-deep"),
    "braces": (f"{ROBOT}let: {'{a: ' * 5_000}{'}' * 5_000}\n", "yaml-too-deep"),
    "chain-of-lets": (lets(*((f"a{n}", f"${{a{n + 1} + 1}}") for n in range(3_000)), ("a3000", "1")), "expression"),
    "chain-with-a-mistake": (
        lets(*((f"a{n}", f"${{a{n + 1} + 1}}") for n in range(3_000)), ("a3000", "${zz}")),
        "expression",
    ),
    "list-in-list": (lets(("a0", "[1]"), *((f"a{n + 1}", f'["${{a{n}}}"]') for n in range(3_000))), ""),
    "line-of-text": (lets(("x", f'"{"a" * 10_000_000}"')), ""),
    "line-of-digits": (lets(("x", "9" * 10_000_000)), ""),
    "line-of-units": (lets(("x", f"9 {'m*' * 5_000_000}m")), ""),
    "line-of-items": (lets(("x", f"[{'1,' * 5_000_000}1]")), "yaml-too-large"),
    "line-of-an-expression": (lets(("x", f'"${{{"1+" * 5_000_000}1}}"')), "expression"),
    "line-of-openings": (lets(("x", f'"{"${" * 5_000_000}"')), "expression"),
    "line-of-a-key": (f'robot: bomb\nlinks: {{"{"a" * 10_000_000}": {{}}}}\n', "yaml-syntax"),
    "many-mistakes": (ROBOT + "".join(f'  l{n}: {{x: "${{zz}}"}}\n' for n in range(2_000)), "expression"),
    "many-names": (lets(*((f"name_{n}", f"${{nmae_{n}}}") for n in range(1_000))), "expression"),
    "many-roots": (f'{ROBOT}  "l${{i}}": {{for: {{i: "${{range(50000)}}"}}}}\n', "several-roots"),
    "comment": (f"{ROBOT}#{'#' * 10_000_000}\n", ""),
}
LONG = {"parts-22", "many-roots", "line-of-items", "line-of-openings", "line-of-an-expression", "list-in-list"}


@pytest.fixture(scope="module")
def limited() -> Iterator[subprocess.Popen[str]]:
    """A process that holds descriptions, each in a child of its own that may take no more than it is given."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "bufsize": 1}
    environment = {**os.environ, "PYTHONPATH": str(TESTS)}
    with subprocess.Popen([sys.executable, "-m", "support.fuzzing"], env=environment, **pipes) as process:
        yield process


@pytest.mark.landing("fuzz", *(BOMBS.keys() - LONG))
@pytest.mark.parametrize("name", BOMBS)
def test_what_grows_is_stopped(name: str, tmp_path: Path, limited: subprocess.Popen[str]) -> None:
    text, rule = BOMBS[name]
    write({"robot.yaml": text}, tmp_path)
    limited.stdin.write(f"{tmp_path} {SECONDS} {MEGABYTES}\n")
    ended = limited.stdout.readline().strip()
    wrong = (tmp_path / "stderr").read_text("utf-8", "replace")
    assert ended == "0", wrong[-2_000:] or f"killed: {ended}"
    assert wrong == ""
    assert rule in json.loads((tmp_path / "told.json").read_text("utf-8")) or not rule


@pytest.mark.parametrize("data", [ROBOT.encode("utf-16"), "robot: größe\n".encode("latin-1"), bytes(range(256)), b""])
@pytest.mark.parametrize("text", ["include: [other.yaml]", "let: {x: '${load(\"other.yaml\")}'}"])
def test_other_encodings(data: bytes, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    write({"robot.yaml": f"{ROBOT}{text}\n", "other.yaml": data}, tmp_path)
    made = held(Path("robot.yaml"))
    assert made.robot is None or (data == b"" and "load" in text)


@pytest.mark.parametrize(
    "path", ["robot.yaml", ".", "", "/etc/passwd", "../x", "a" * 5_000, "a\\0b", "\\ud800", "big.yaml", "no/such/file"]
)
def test_names_of_files(path: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is named by a description: itself, none, outside, too large, or no name at all."""
    monkeypatch.chdir(tmp_path)
    for text in (
        f'include: ["{path}"]\n',
        f'use: {{u: {{part: "{path}/x"}}, v: {{part: "os:{path}/x"}}, w: {{part: "{path}:a/x"}}}}\n',
        f"let: {{x: '${{load(\"{path}\")}}'}}\n",
    ):
        write({"robot.yaml": ROBOT + text, "big.yaml": b"a" * 20_000_001}, tmp_path)
        made = held(Path("robot.yaml"))
        assert made.robot is None or (path, text[:3]) == ("robot.yaml", "let")


@pytest.mark.parametrize(
    ("seed", "step"), [(1, 4), *(pytest.param(seed, 1, marks=pytest.mark.tier("fuzz")) for seed in range(4))]
)
def test_any_value_and_any_key_at_any_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int, step: int
) -> None:
    """At each place of a description that uses the whole language something is wrong."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(seed)  # noqa: S311
    files = {path.name: path.read_text("utf-8") for path in sorted((DATA / "whole").glob("*.yaml"))}
    write(files, tmp_path)
    assert len(held(Path("robot.yaml")).artifacts) == 8
    refused = 0
    for name, text in files.items():
        for changed in with_a_mistake(text, chance, step):
            (tmp_path / name).write_text(changed, "utf-8")
            refused += held(Path("robot.yaml")).robot is None
        (tmp_path / name).write_text(text, "utf-8")
    assert refused > 75


ATOMS = """
1 0 -1 2.5 1e300 10**18 'a' '' 'mm' [] x side length table spots nothing mm deg kg + - * / // % **
== != < >= i ( ) [ ] , : . =
"""
WORDS = [*ATOMS.split(), *CONSTANTS, *(f"{name}(" for name in (*FUNCTIONS, "load", "open", "__import__"))]
WORDS += ["[1, 2]", "[[1, 2], [3, 4]]", " in ", " not in ", " and ", " or ", "not ", " if ", " else ", " for i in "]
NAMES = {
    "x": 0.05,
    "side": "left",
    "length": Quantity(2.0, LENGTH),
    "spots": [["a", 1], ["b", 2]],
    "table": {"a": {"b": 1}},
}


@settings(max_examples=1_500, deadline=None, derandomize=True, database=None)
@given(st.lists(st.sampled_from(WORDS), max_size=14).map("".join))
def test_any_expression(text: str) -> None:
    """Its value is one that a description can hold, or it is refused in words of the language, not of Python."""
    try:
        value, said = evaluate(text, NAMES.__getitem__), ""
    except ExpressionError as problem:
        value, said = None, problem.message or "no message: object"
    assert value is None or isinstance(value, (bool, int, float, str, list, dict))
    python = ("object", "NoneType", "argument", "unhashable", "subscript", "iterable")
    assert not any(word in said for word in python), said


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(st.binary(max_size=200) | st.text(alphabet="{}[]:,-&*!|>'\"% \n\tab#?1$<", max_size=80).map(str.encode))
def test_any_file(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    folder = tmp_path_factory.getbasetemp() / "any_file"
    folder.mkdir(exist_ok=True)
    write({"robot.yaml": data}, folder)
    held(folder / "robot.yaml")


# Any finite number anywhere: a robot compiles into artifacts that agree with it, or says what is wrong.


ROBOT_NUMBERS = data_text("extreme_numbers.yaml")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.%])")
NUMBERS = [found.span() for found in _NUMBER.finditer(ROBOT_NUMBERS)]
EXTREME = ["1.7976931348623157e308", "1e308", "1e300", "1e200", "1e155", "1e149", "1e110", "1e100", "1e30", "9e29"]
EXTREME += ["1e18", "1e16", "1e10"]
EXTREME += ["9007199254740993", "5e-324", "1e-308", "1e-300", "1e-160", "1e-30", "1e-12", "0", "255"]
EXTREME += [f"-{text}" for text in EXTREME]
_NO_NUMBER = re.compile(r"(?<![\w\"'])[-+]?(?:nan|inf)(?![\w\"'])", re.IGNORECASE)


def compile_with(folder: Path, changes: dict[int, str]) -> list[Diagnostic]:
    """Compile the robot with other numbers; its artifacts agree with the model."""
    text = ROBOT_NUMBERS
    for number, value in sorted(changes.items(), reverse=True):
        start, end = NUMBERS[number]
        text = text[:start] + value + text[end:]
    path = folder / "robot.yaml"
    path.write_text(text, "utf-8")
    made = compile_robot(path)
    if has_errors(made.diagnostics):
        assert not made.artifacts
        assert all(one.span is not None for one in made.diagnostics if one.severity == "error"), made.diagnostics
        return made.diagnostics
    assert made.robot is not None
    assert made.artifacts
    assert agreement(made.robot, made.artifacts) == []
    for artifact in made.artifacts:
        if artifact.backend != "page":  # whose program has those words
            assert _NO_NUMBER.search(artifact.text) is None, artifact.file
    return made.diagnostics


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    changes=st.dictionaries(
        st.integers(0, len(NUMBERS) - 1),
        st.one_of(st.sampled_from(EXTREME), st.floats(allow_nan=False, allow_infinity=False).map(repr)),
        min_size=1,
        max_size=3,
    )
)
@example(
    changes={NUMBERS.index(found.span()): "9e15" for found in _NUMBER.finditer(ROBOT_NUMBERS) if found[0] == "0.35"}
)
@example(changes={55: "0"})  # the axis of a joint that is damped
@example(changes={102: "1.7976931348623157e308"})  # a limit that SDF takes as none
def test_any_numbers(tmp_path: Path, changes: dict[int, str]) -> None:
    compile_with(tmp_path, changes)


@pytest.mark.tier("fuzz")
@pytest.mark.parametrize("number", range(len(NUMBERS)))
def test_each_number_at_each_extreme(tmp_path: Path, number: int) -> None:
    assert not has_errors(compile_with(tmp_path, {}))
    for value in EXTREME:
        compile_with(tmp_path, {number: value})


JOINTS = "links: {b: {}, a: {}}\njoints: {j: {type: fixed, parent: b, child: a, xyz: "


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("links: {b: {collision: [{sphere: {radius: VALUE}}]}}", "1e151"),
        ("links: {b: {inertial: {mass: 1, inertia: {ixx: VALUE, iyy: 1, izz: 1}}}}", "1e308"),
        (f"{JOINTS}[0, VALUE, 0]}}}}", "-1e151"),
        (f"{JOINTS}[0, VALUE m, 0]}}}}", "1e151"),
        ("links: {b: {inertial: {mass: VALUE, inertia: {ixx: 1, iyy: 1, izz: 1}}}}", ""),  # it has a rule of its own
        ("links: {b: {}}\npublishers: {n: {package: p}}\nposes: {home: {mjcf: {time: VALUE}}}", "1e151"),
    ],
)
def test_numbers_that_are_too_large_to_calculate_with(tmp_path: Path, text: str, value: str) -> None:
    path = tmp_path / "robot.yaml"
    text = f"robot: r\n{text.replace('VALUE', value or '1e151')}\noutputs: {{urdf: {{file: r.urdf}}}}\n"
    path.write_text(text, "utf-8")
    found = [one.span for one in compile_robot(path).diagnostics if one.rule == "not-finite"]
    assert len(found) == bool(value)
    for span in found:
        assert span is not None
        assert text.splitlines()[span.line - 1][span.column - 1 :].startswith(value)


def test_a_limit_may_be_the_largest_number(tmp_path: Path) -> None:
    """As many files of others say that there is none."""
    most = "1.7976931348623157e308"
    limit = f"{{lower: -{most} rad, upper: {most} rad, effort: {most}, velocity: {most}}}"
    joints = f"{{j: {{type: revolute, parent: b, child: a, axis: [0, 0, 1], limit: {limit}}}}}"
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\nlinks: {{b: {{}}, a: {{}}}}\njoints: {joints}\noutputs: {{urdf: {{file: r.urdf}}}}\n")
    made = compile_robot(path)
    assert not has_errors(made.diagnostics)
    assert made.artifacts
