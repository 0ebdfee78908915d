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
from rosorin_compile.language.expression import CONSTANTS, FUNCTIONS, ExpressionError, evaluate
from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.units import LENGTH, Quantity
from support.fuzzing import VALUES, held, mutated, replaced, steps_of, whole, write
from support.paths import TESTS

pytestmark = pytest.mark.slow

SECONDS, MEGABYTES = 20, 1_000

ROBOT = "robot: bomb\nlinks:\n  base_link: {}\n"


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
    "list-in-list": (lets(("a0", "[1]"), *((f"a{n + 1}", f'["${{a{n}}}"]') for n in range(3_000))), "too-large"),
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


ENCODED = {
    "utf-16": ROBOT.encode("utf-16"),
    "utf-16-be": ROBOT.encode("utf-16-be"),
    "utf-32": ROBOT.encode("utf-32"),
    "latin-1": "robot: größe\n".encode("latin-1"),
    "nul": ROBOT.encode() + b"\0",
    "bytes": bytes(range(256)) * 100,
    "half-a-letter": ROBOT.encode() + "# ö".encode()[:-1],
    "nothing": b"",
}


@pytest.mark.parametrize("name", ENCODED)
@pytest.mark.parametrize("way", ["first", "included", "loaded"])
def test_other_encodings(name: str, way: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    data = ENCODED[name]
    texts = {
        "included": f"{ROBOT}include: [other.yaml]\n",
        "loaded": f"{ROBOT}let: {{x: '${{load(\"other.yaml\")}}'}}\n",
    }
    write({"robot.yaml": texts.get(way, data), "other.yaml": data}, tmp_path)
    made = held(Path("robot.yaml"))
    assert made.robot is None or (name, way) == ("nothing", "loaded")


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


def test_the_whole_description_is_fine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the tests below would break what is broken already."""
    monkeypatch.chdir(tmp_path)
    write(whole(), tmp_path)
    assert len(held(Path("robot.yaml")).artifacts) == 8


@pytest.mark.parametrize("part", [0, *(pytest.param(part, marks=pytest.mark.tier("fuzz")) for part in (1, 2, 3))])
def test_any_value_at_any_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, part: int) -> None:
    """At each place of the description in turn stands something that does not belong there; a fourth at a time."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(20261120)  # noqa: S311
    files = whole()
    refused = 0
    for name, tree in files.items():
        for number, steps in enumerate(steps_of(tree)):
            value = chance.choice(VALUES)
            if number % 4 != part:
                continue
            tell(steps, value)
            write({**files, name: replaced(tree, steps, value)}, tmp_path)
            refused += held(Path("robot.yaml")).robot is None
    assert refused > 75


@pytest.mark.tier("fuzz")
@pytest.mark.parametrize("seed", [1123, *(pytest.param(seed, marks=pytest.mark.tier("fuzz")) for seed in range(4))])
def test_any_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    """Values, keys and entries are replaced, added, removed and exchanged, up to three at a time."""
    monkeypatch.chdir(tmp_path)
    chance = random.Random(seed)  # noqa: S311
    for number in range(100):
        files = whole()
        for _ in range(chance.choice([1, 1, 2, 3])):
            files = mutated(files, chance)
        tell(number)
        write(files, tmp_path)
        held(Path("robot.yaml"))


def tell(*what: object) -> None:
    """Print what is tried; pytest shows it after a failure."""
    sys.stdout.write(f"{what}\n")


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
    problem = problem_of(text)
    if problem is not None:
        python = ("object", "NoneType", "argument", "unhashable", "subscript", "iterable")
        assert problem.message
        assert not any(word in problem.message for word in python), problem.message


def problem_of(text: str) -> ExpressionError | None:
    """Return what is wrong with an expression; its value is one that a description can hold."""
    try:
        value = evaluate(text, NAMES.__getitem__)
    except ExpressionError as problem:
        return problem
    assert value is None or isinstance(value, (bool, int, float, str, list, dict))
    return None


@settings(max_examples=300, deadline=None, derandomize=True, database=None)
@given(st.binary(max_size=200) | st.text(alphabet="{}[]:,-&*!|>'\"% \n\tab#?1$<", max_size=80).map(str.encode))
def test_any_file(tmp_path_factory: pytest.TempPathFactory, data: bytes) -> None:
    folder = tmp_path_factory.getbasetemp() / "any_file"
    folder.mkdir(exist_ok=True)
    write({"robot.yaml": data}, folder)
    held(folder / "robot.yaml")


# Any finite number anywhere: a robot compiles into artifacts that agree with it, or says what is wrong.


ROBOT_NUMBERS = (Path(__file__).parent.parent / "data" / "extreme_numbers.yaml").read_text("utf-8")
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.%])")
NUMBERS = [found.span() for found in _NUMBER.finditer(ROBOT_NUMBERS)]
EXTREME = ["1.7976931348623157e308", "1e308", "1e300", "1e200", "1e155", "1e149", "1e110", "1e100", "1e30", "9e29"]
EXTREME += ["1e18", "1e16", "1e10"]
EXTREME += ["9007199254740993", "5e-324", "1e-308", "1e-300", "1e-160", "1e-30", "1e-12", "0", "255"]
EXTREME += [f"-{text}" for text in EXTREME]
_NO_NUMBER = re.compile(r"(?<![\w\"'])[-+]?(?:nan|inf)(?![\w\"'])", re.IGNORECASE)


def told(folder: Path, changes: dict[int, str]) -> list[Diagnostic]:
    """Compile the robot with other numbers; what comes of it has to hold against the model."""
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


def test_the_robot_itself_is_sound(tmp_path: Path) -> None:
    assert not has_errors(told(tmp_path, {}))


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
    told(tmp_path, changes)


@pytest.mark.tier("fuzz")
@pytest.mark.parametrize("number", range(len(NUMBERS)))
def test_each_number_at_each_extreme(tmp_path: Path, number: int) -> None:
    for value in EXTREME:
        told(tmp_path, {number: value})


PLACES = {
    "links": "links: {{b: {{collision: [{{sphere: {{radius: {}}}}}]}}}}",
    "inertia": "links: {{b: {{inertial: {{mass: 1, inertia: {{ixx: {}, iyy: 1, izz: 1}}}}}}}}",
    "pose": "links: {{b: {{}}, a: {{}}}}\njoints: {{j: {{type: fixed, parent: b, child: a, xyz: [0, {}, 0]}}}}",
    "quantity": "links: {{b: {{}}, a: {{}}}}\njoints: {{j: {{type: fixed, parent: b, child: a, xyz: [0, {} m, 0]}}}}",
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("value", ["1e151", "-1e151", "1e308"])
def test_what_nothing_can_be_calculated_with_is_told_at_its_place(tmp_path: Path, place: str, value: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\n{PLACES[place].format(value)}\noutputs: {{urdf: {{file: r.urdf}}}}\n", "utf-8")
    found = [one for one in compile_robot(path).diagnostics if one.rule == "not-finite"]
    assert len(found) == 1
    assert f"is {float(value):g}, and nothing can be calculated with more than 1e+150" in found[0].message
    span = found[0].span
    assert span is not None
    assert path.read_text("utf-8").splitlines()[span.line - 1][span.column - 1 :].startswith(value)


@pytest.mark.parametrize(
    "place",
    [
        "links: {{b: {{inertial: {{mass: {}, inertia: {{ixx: 1, iyy: 1, izz: 1}}}}}}}}",
        "links: {{b: {{}}}}\npublishers: {{n: {{package: p}}}}\nposes: {{home: {{mjcf: {{time: {}}}}}}}",
    ],
)
def test_what_is_not_calculated_with_or_has_a_rule_of_its_own_is_not_told_so(tmp_path: Path, place: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(f"robot: r\n{place.format('1e151')}\noutputs: {{urdf: {{file: r.urdf}}}}\n", "utf-8")
    assert [one for one in compile_robot(path).diagnostics if one.rule == "not-finite"] == []


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
