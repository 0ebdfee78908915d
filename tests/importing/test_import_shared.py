"""import --into: a file that robots of one package share grows, and why a robot has one of its own."""

from pathlib import Path

import pytest

from rosorin_compile.importing.xacro.merge import merged, renewed, with_more
from support.paths import data_text

from .test_import_into import BOX, INCLUDE, POLE, SHARED, TEST, brought, described, files, package, robots, run, tried

__all__ = ["package"]
COMMON = "descriptions/common/body.yaml"
GROWN = f"{COMMON} has more now, and the other robots that include it are the same as before"


def alone(package: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Import the second robot, which shares no file; return why."""
    before = files(package)
    capsys.readouterr()
    assert brought(package, "four") == "body.yaml"
    after = files(package)
    assert {name: after[name] for name in before} == before
    told = capsys.readouterr().out
    (line,) = [line for line in told.split("\n") if line.startswith("body.yaml is of this robot alone, since ")]
    return line.removeprefix("body.yaml is of this robot alone, since ")


# It grows.


@pytest.mark.landing("builds", "order1")
@pytest.mark.slow
@pytest.mark.parametrize("order", [("two", "four"), ("four", "two")])
def test_a_shared_file_has_the_macros_of_all_robots(
    package: Path, capsys: pytest.CaptureFixture[str], order: tuple[str, str]
) -> None:
    robots(package, two=INCLUDE + '<link name="base_link"/>' + POLE, four=INCLUDE + BOX)
    assert brought(package, order[0]) == "../common/body.yaml"
    robot = (package / "descriptions" / order[0] / "robot.yaml").read_bytes()
    assert GROWN not in capsys.readouterr().out
    assert brought(package, order[1]) == "../common/body.yaml"
    told = capsys.readouterr().out
    assert f"\n{GROWN}\n" in told
    assert f"written: descriptions/common, descriptions/{order[1]}, test/" in told
    assert described(package) == ["common/body.yaml"]
    assert (package / "descriptions" / order[0] / "robot.yaml").read_bytes() == robot
    text = (package / COMMON).read_text()
    assert sorted(line for line in text.split("\n") if line.startswith("  ") and line[2] != " ") == [
        "  box:",
        "  pole:",
    ]
    for name in order:
        brought(package, name)
        assert "cart_description: unchanged" in capsys.readouterr().out
    tried(package)


@pytest.mark.tier("builds")
@pytest.mark.slow
def test_what_somebody_has_edited_in_a_shared_file_stays_when_it_grows(package: Path) -> None:
    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    edited = (package / COMMON).read_text().replace("  box:\n", "  # ours\n  box:\n")
    edited = edited.replace("parts:\n", "let:\n  ours: 3 # as measured\nparts:\n").replace("links:", "links:   # one")
    (package / COMMON).write_text(edited)
    assert brought(package, "four") == "../common/body.yaml"
    assert (package / COMMON).read_text().startswith(edited.rstrip("\n"))
    tried(package)


INERTIAL = data_text("robots/import_shared_inertial.xacro")


@pytest.mark.slow
def test_robots_that_hand_over_other_things_share_a_file(package: Path) -> None:
    """Blocks without one of their values, a length that elements of one robot print, arguments that one leaves out."""

    def body(origin: str, more: str) -> str:
        block = f'<link name="base_link"><xacro:solid mass="9"><origin {origin}/></xacro:solid></link>'
        size = '<xacro:property name="s" value="0.2"/>'
        return f'{INCLUDE}{size}{block}<xacro:lens prefix="a" size="${{s}}" {more}><origin {origin}/></xacro:lens>'

    second = ('xyz="1 0 0"', 'hood="$(arg h)"')
    robots(
        package,
        INERTIAL,
        two=body("", ""),
        four=f'<xacro:arg name="h" default="true"/>{body(*second)}<xacro:control size="${{s}}"/>',
        six=body('xyz="1 0 0" rpy="0 0 1"', 'hood="true"'),
    )
    for name in ("two", "four", "six"):
        assert brought(package, name) == "../common/body.yaml"
    assert described(package) == ["common/body.yaml"]
    tried(package)


# It is of a robot alone.


@pytest.mark.slow
def test_what_somebody_has_changed_in_a_shared_file_is_told_of_a_robot_that_needs_it_as_it_was(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    (package / COMMON).write_text((package / COMMON).read_text().replace('size: ["${size}", ', "size: [1, "))
    why = 'line 2, part "box" differs (body.xacro:2)'
    assert alone(package, capsys) == f"{COMMON} is another: {why}"


@pytest.mark.slow
def test_what_a_macro_reads_is_told_with_why_it_is_another(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tall = SHARED.replace('length="2"', "length=\"${3 if tall and '$(arg up)' == 'true' else 2}\"")
    given = '<xacro:arg name="up" default="true"/>\n<xacro:property name="tall" value="true"/>'
    robots(package, tall, two=given + INCLUDE + BOX + POLE, four=given + INCLUDE + BOX + POLE)
    brought(package, "two")
    (package / COMMON).write_text((package / COMMON).read_text().replace("${3 if", "${4 if"))
    why = alone(package, capsys)
    assert why.endswith('part "pole" differs (body.xacro:5)')


DEFAULT = SHARED.replace("</robot>", '<xacro:property name="high" default="2"/></robot>')
DEFAULT = DEFAULT.replace('length="2"', 'length="${high}"')
OWN_HIGH = '<xacro:property name="high" value="4"/>'


@pytest.mark.landing("builds", "first")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        (
            OWN_HIGH + INCLUDE + BOX + POLE,
            INCLUDE + BOX + POLE,
            'is another: line 2, value "high" differs (body.xacro:8)',
        ),
        (
            INCLUDE + BOX + POLE,
            OWN_HIGH + INCLUDE + BOX + POLE,
            'would make another robot of it: the value "high" is named twice (robot.yaml:7)',
        ),
    ],
    ids=["first", "second"],
)
def test_a_default_that_one_robot_sets_anew_is_told(
    package: Path, capsys: pytest.CaptureFixture[str], first: str, second: str, why: str
) -> None:
    robots(package, DEFAULT, two=first, four=second)
    brought(package, "two")
    assert alone(package, capsys) == f"{COMMON} {why}"
    tried(package)


@pytest.mark.tier("builds")
@pytest.mark.slow
def test_a_macro_that_was_changed_since_is_told(package: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robots(package, two=INCLUDE + BOX + POLE, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    robots(package, SHARED.replace('length="2"', 'length="3"'))
    (package / TEST.replace("cart", "two")).unlink()
    where = 'line 14, part "pole" links ${name} collision cylinder length'
    assert alone(package, capsys) == f"{COMMON} is another: {where} is 2 there, and 3 here (body.xacro:5)"
    tried(package)


@pytest.mark.slow
def test_a_file_does_not_grow_where_that_changes_another_robot(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    high = SHARED.replace('length="2"', 'length="${high}"').replace(
        "</robot>", '<xacro:property name="high" value="2"/></robot>'
    )
    robots(package, high, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    robot = package / "descriptions" / "two" / "robot.yaml"
    robot.write_text(robot.read_text().replace("use:\n", "let:\n  high: 5\n\nuse:\n"))
    why = 'with more in it descriptions/two does not compile any more: the value "high" is named twice (robot.yaml:7)'
    assert alone(package, capsys) == f"{COMMON} is another: {why}"


@pytest.mark.slow
def test_a_file_does_not_grow_under_a_robot_that_does_not_compile(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    robot = package / "descriptions" / "two" / "robot.yaml"
    robot.write_text(robot.read_text().replace("size: 0.3", "size: wide"))
    assert "descriptions/two cannot be compared, since it does not compile: " in alone(package, capsys)


@pytest.mark.slow
def test_a_file_that_was_changed_while_a_robot_was_imported_stays(
    package: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from rosorin_compile.importing import into

    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    brought(package, "two")
    whole = into._has_files

    def meanwhile(*words):  # type: ignore[no-untyped-def]
        (package / COMMON).write_text((package / COMMON).read_text() + "# mine\n")
        return whole(*words)

    monkeypatch.setattr(into, "_has_files", meanwhile)
    run(package / "urdf" / "four.urdf.xacro", "--into", package, "--trust")
    assert (package / COMMON).read_text().endswith("# mine\n")
    assert f"{COMMON} is there with changes of its own" in capsys.readouterr().out


# Texts.

THERE = data_text("robots/import_shared_there.yaml")
OWN = data_text("robots/import_shared_own.yaml")
BOTH = data_text("robots/import_shared_both.yaml")


def test_what_a_text_has_more_is_put_behind_what_is_there() -> None:
    assert merged(THERE, OWN).text == BOTH
    assert merged(BOTH, OWN).text == BOTH
    assert merged(BOTH, THERE).text == BOTH
    assert merged("let:\n  a: 1\n", "let:\n  b: 2\n").text == "let:\n  a: 1\n  b: 2\n"


def test_what_is_there_does_for_another_only_where_it_is_there() -> None:
    assert merged("let:\n  a: 1\n", "let:\n  a: 2\n  b: 3\n", keep=True).text == "let:\n  a: 1\n  b: 3\n"
    assert merged("let:\n  a: 1\n", "links:\n  a: {}\n", keep=True).text == ""
    assert merged("let:\n  a(b): 1\n", "let:\n  a(b, c): 1\n", keep=True).text == ""


@pytest.mark.parametrize(
    ("record", "text", "result"),
    [
        ("let:\n  a: 1\n  b: 2\n", "let:\n  b: 3\n  c: 4\n", "let:\n  a: 1\n  b: 3\n  c: 4\n"),
        ("parts:\n    a:\n        x: 1\n", "parts:\n  a:\n    x: 2\n", "parts:\n    a:\n      x: 2\n"),
        ("parts:\n  a: {}\n", "links:\n  b: {}\n\nparts:\n  c: {}\n", "links:\n  b: {}\n\nparts:\n  a: {}\n  c: {}\n"),
        ("let: {a: 1, b: 2}\n", "let: {b: 3}\n", "let: {b: 3}\n"),
    ],
)
def test_entries_of_a_shared_file_are_replaced_and_the_others_stay(record: str, text: str, result: str) -> None:
    assert renewed(record, text) == result


def test_the_record_of_a_shared_file_gets_what_a_robot_adds() -> None:
    before = "let:\n  a: 5\n  mine: 2\n"
    assert with_more("let:\n  a: 1\n", before, f"{before}  c: 4\n") == "let:\n  a: 1\n  c: 4\n"
