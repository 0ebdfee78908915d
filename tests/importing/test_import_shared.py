"""import --into: robots of one package share a file only if it has the same entries for all of them."""

from pathlib import Path

import pytest

from .test_import_into import BOX, INCLUDE, POLE, WHEEL, brought, described, files, package, robots, tried

__all__ = ["package"]
COMMON = "descriptions/common/body.yaml"


@pytest.mark.slow
def test_a_robot_that_needs_other_macros_has_a_file_of_its_own(
    package: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + POLE)
    assert brought(package, "two") == "../common/body.yaml"
    before = files(package)
    capsys.readouterr()
    assert brought(package, "four") == "body.yaml"
    after = files(package)
    assert {name: after[name] for name in before} == before
    assert f"\nbody.yaml is of this robot alone, since {COMMON} is another\n" in capsys.readouterr().out
    for name in ("two", "four"):
        brought(package, name)
        assert "cart_description: unchanged" in capsys.readouterr().out
    assert described(package) == ["common/body.yaml", "four/body.yaml"]
    tried(package)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "place"),
    [("parts:", "parts:  # mine", "../common/body.yaml"), ('size: ["${size}", ', "size: [1, ", "body.yaml")],
    ids=["a comment", "a value"],
)
def test_an_edited_file_is_shared_if_its_entries_are_the_same(package: Path, old: str, new: str, place: str) -> None:
    robots(package, two=INCLUDE + BOX, four=INCLUDE + BOX + WHEEL)
    brought(package, "two")
    edited = (package / COMMON).read_text().replace(old, new)
    assert new in edited
    (package / COMMON).write_text(edited)
    assert brought(package, "four") == place
    assert (package / COMMON).read_text() == edited
