"""Lists of variants: what a CSV, a YAML file and a folder say, and what is wrong with one, with its place."""

from pathlib import Path

import pytest

from rosorin_compile.source.diagnostics import text
from rosorin_compile.variants.variants import Variants

ARGUMENTS = ["mast", "label", "calibration"]


@pytest.fixture(autouse=True)
def here(home: Path) -> Path:
    return home


def listed(text: str, name: str = "fleet.csv") -> Variants:
    Path(name).write_text(text, encoding="utf-8")
    variants = Variants(Path(name), ARGUMENTS)
    assert variants.check() == []
    return variants


def told(text: str | bytes, name: str = "fleet.csv") -> list[str]:
    Path(name).write_bytes(text.encode() if isinstance(text, str) else text)
    return [f"{one}; {one.help}" for one in Variants(Path(name), ARGUMENTS).check()]


def plain(variants: Variants) -> dict[str, dict[str, object]]:
    return {variant.name: dict(variant.arguments) for variant in variants}


TEXTS = ["name,mast,label\nr1,12 mm,a\nr2,,b\n", "\ufeffname,mast,label\r\nr1,12 mm,a\r\nr2,,b\r\n"]
TEXTS += ["name;mast;label\nr1;12 mm;a\nr2;;b\n", "name\tmast\tlabel\nr1\t12 mm\ta\nr2\t\tb"]
TEXTS += ["name;mast;label\nr1;12 mm;a\nr2;;b\n", 'name, mast, label\n"r1", 12 mm , "a"\n\n,,\nr2,,b\n']
TEXTS += ["label,name,mast,\na,r1,12 mm,\nb,r2,,\n"]


@pytest.mark.parametrize("text", TEXTS)
def test_tables_that_spreadsheets_write_say_the_same(text: str) -> None:
    assert plain(listed(text)) == {"r1": {"mast": "12 mm", "label": "a"}, "r2": {"label": "b"}}


def test_each_cell_knows_its_place() -> None:
    text = 'name,label,mast\nr1,"a, ""b""",1 m\nr2,"two\nlines",  2 m\n'
    first, second = listed(text)
    assert first.arguments["label"] == 'a, "b"'
    places = [(place.line, place.column) for place in (first.span, *first.arguments.value_spans.values()) if place]
    assert places == [(2, 1), (2, 4), (2, 15)]
    place = second.arguments.value_spans["mast"]
    assert (place.line, place.column, place.length) == (4, 10, 3)
    assert place.source.line(4) == 'lines",  2 m'


@pytest.mark.parametrize(
    "text",
    [
        "r1: {mast: 12 mm}\nr2:\n",
        "- {name: r1, mast: 12 mm}\n- {name: r2}\n",
        '[\n\t{"name": "r1", "mast": "12 mm"},\n\t{"name": "r2"}\n]\n',
    ],
)
def test_a_tree_is_a_mapping_or_a_list(text: str) -> None:
    name = "fleet.json" if text.startswith("[") else "fleet.yaml"
    assert {key: {k: str(v) for k, v in value.items()} for key, value in plain(listed(text, name)).items()} in (
        {"r1": {"mast": "0.012"}, "r2": {}},
        {"r1": {"mast": "12 mm"}, "r2": {}},
    )


def test_a_number_is_a_name_as_it_is_written() -> None:
    assert list(plain(listed("- {name: 0007, mast: 1}\n- {name: 1e3}\n", "fleet.yaml"))) == ["0007", "1e3"]


def test_a_folder_has_a_file_a_variant() -> None:
    folder = Path("cal")
    folder.mkdir()
    (folder / "r2.json").write_text('{"calibration": {"x": [1, 2]}}')
    (folder / "r1.yaml").write_text("calibration: {x: 3 mm}\n")
    (folder / "README.md").write_text("no variant")
    (folder / ".r3.yaml").write_text("hidden: 1")
    variants = Variants(folder, ARGUMENTS)
    assert variants.check() == []
    assert len(variants) == 2
    assert plain(variants) == {"r1": {"calibration": {"x": 0.003}}, "r2": {"calibration": {"x": [1, 2]}}}
    whole = Variants(folder, ARGUMENTS, "mast")
    assert whole.check() == []
    assert plain(whole)["r2"] == {"mast": {"calibration": {"x": [1, 2]}}}
    path = Variants(folder, ARGUMENTS, "mast", home=Path("descriptions/rover"))
    assert path.check() == []
    assert plain(path)["r1"] == {"mast": "../../cal/r1.yaml"}


def test_a_broken_file_of_a_folder_is_wrong_with_its_variant_alone() -> None:
    folder = Path("cal")
    folder.mkdir()
    (folder / "good.yaml").write_text("mast: 1\n")
    (folder / "list.yaml").write_text("[1]\n")
    (folder / "torn.yaml").write_text("mast: {\n")
    (folder / "sum.yaml").write_text("mast: ${1 + 1}\n")
    variants = Variants(folder, ARGUMENTS)
    assert variants.check() == []
    wrong = {one.name: text(one.diagnostics).partition("\n")[0] for one in variants if one.diagnostics}
    assert wrong["list"].startswith("cal/list.yaml:1:1: error[not-a-mapping]: ")
    assert wrong["torn"].startswith("cal/torn.yaml:1:7: error[yaml-syntax]: ")
    assert wrong["sum"].startswith("cal/sum.yaml:1:7: error[bad-argument]: ")
    assert "good" not in wrong


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "fleet.csv:1:1: error[variants-list]"),
        ("name,mast\n", "error[variants-list]"),
        ("Name,mast\nr1,1\n", "fleet.csv:1:1: error[variants-list]"),
        ("serial,mast\nr1,1\n", "fleet.csv:1:1: error[variants-list]"),
        ("name,mats\nr1,1\n", "fleet.csv:1:6: error[unknown-argument]"),
        ("name,mast,mast\nr1,1,2\n", "fleet.csv:1:11: error[variants-list]"),
        ("name,mast\nr1\n", "fleet.csv:2:1: error[variants-list]"),
        ("name,label\nr1,a,b\n", "fleet.csv:2:6: error[variants-list]"),
        ("name,mast,\nr1,1,2\n", "fleet.csv:2:6: error[variants-list]"),
        ('name,label\nr1,"torn\n', "fleet.csv:2:1: error[variants-list]"),
        ("name\n\nr1\nr2\nr1\n", "fleet.csv:5:1: error[variant-name]"),
        ("name\nr1\nR1\n", "fleet.csv:3:1: error[variant-name]"),
        ("name\na/b\n", "fleet.csv:2:1: error[variant-name]"),
        ("name\n..\n", "fleet.csv:2:1: error[variant-name]"),
        ("name\nSweep.json\n", "fleet.csv:2:1: error[variant-name]"),
        ("name,mast\n,1\n", "fleet.csv:2:1: error[variant-name]"),
        ("name\nr\x001\n", "fleet.csv:2:1: error[variant-name]"),
        (f"name\n{'r' * 201}\n", "fleet.csv:2:1: error[variant-name]"),
        ("name\ngr\xf6\xdfe\n".encode("latin-1"), "fleet.csv:2:3: error[not-utf8]"),
    ],
)
def test_errors_in_a_table(text: str | bytes, place: str) -> None:
    assert told(text)[0].startswith(f"{place}: "), told(text)


def test_suggestions_for_misspelt_columns() -> None:
    assert "Name" in told("Name,mast\nr1,1\n")[0]
    assert told("name,mats\nr1,1\n")[0].endswith('did you mean "mast"?')


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", "error[variants-list]"),
        ("- r1\n", "fleet.yaml:1:3: error[variants-list]"),
        ("- {mast: 1}\n", "fleet.yaml:1:3: error[variant-name]"),
        ("r1: 5\n", "fleet.yaml:1:5: error[variants-list]"),
        ("r1: {}\nr1: {}\n", "fleet.yaml:2:1: error[duplicate-key]"),
        ("just text\n", "fleet.yaml:1:1: error[not-a-mapping]"),
        ("r1: {a: 1, a: 2}\n", "fleet.yaml:1:12: error[duplicate-key]"),
        ("r1: {\n", "fleet.yaml:1:5: error[yaml-syntax]"),
        ("r1: {}\n---\nr2: {}\n", "fleet.yaml:2:1: error[yaml-documents]"),
    ],
)
def test_errors_in_a_tree(text: str, place: str) -> None:
    assert told(text, "fleet.yaml")[0].startswith(f"{place}: "), told(text, "fleet.yaml")


def test_paths_that_are_not_lists() -> None:
    assert told("", "fleet.xlsx")[0].startswith("error[variants-list]: ")
    assert str(Variants(Path("none.csv"), []).check()[0]).startswith("error[file-unreadable]: ")
    Path("empty").mkdir()
    assert str(Variants(Path("empty"), []).check()[0]).startswith("error[variants-list]: ")
