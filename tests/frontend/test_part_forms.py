"""Parts stay as they were written, whatever is joined to an instance; what cannot be a part or a use is told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.formats.compiled import Compiled
from rosorin_compile.source.diagnostics import text as report
from support.robots import compiled_text

JOINT = {"type": "fixed", "parent": "mount", "child": "leg"}
PART: dict[str, Any] = {"links": {"leg": {}}, "joints": {"hip": JOINT}}


def compiled_parts(folder: Path, **description: Any) -> Compiled:
    """Compile a description that is made in Python."""
    whole = {"robot": "made", "outputs": {"urdf": {"file": "r.urdf"}}, "links": {"body": {}}, **description}
    return compiled_text(folder, yaml.safe_dump(whole, sort_keys=False))


def links(made: Compiled) -> list[str]:
    assert made.robot is not None, report(made.diagnostics)
    return sorted(link.name for link in made.robot.links)


def use(**more: Any) -> dict[str, Any]:
    return {"part": "leg", "parent": "body", **more}


def test_content_of_one_instance_is_not_in_the_next(tmp_path: Path) -> None:
    content = {"links": {"foot": {}}, "joints": {"ankle": {"type": "fixed", "parent": "leg", "child": "foot"}}}
    made = compiled_parts(tmp_path, parts={"leg": PART}, use={"a": use(content=content), "b": use()})
    assert links(made) == ["a_foot", "a_leg", "b_leg", "body"]


def test_parts_of_one_instance_are_not_in_the_next(tmp_path: Path) -> None:
    again = {"if": "${n > 0}", **use(parent="leg"), "with": {"n": "${n - 1}"}}
    part = {**PART, "params": {"n": {"type": "integer"}}, "use": {"next": again}}
    uses = {name: {**use(), "with": {"n": n}} for name, n in (("a", 2), ("b", 0))}
    made = compiled_parts(tmp_path, parts={"leg": part}, use=uses)
    assert links(made) == ["a_leg", "a_next_leg", "a_next_next_leg", "b_leg", "body"]


@pytest.mark.parametrize("pose", [{}, {"xyz": [1, 0, 0]}, {"mirror": "x"}])
def test_wrong_unit_in_a_part_is_told_however_it_is_placed(tmp_path: Path, pose: dict[str, Any]) -> None:
    hip = {**JOINT, "xyz": ["2 kg", 0, 0]}
    made = compiled_parts(tmp_path, parts={"leg": {**PART, "joints": {"hip": hip}}}, use={"a": use(**pose)})
    (found,) = [found for found in made.diagnostics if found.severity == "error"]
    assert found.rule == "wrong-unit"
    assert "2 kg is a mass (kg)" in found.message


def test_place_for_a_part_that_is_nowhere_attached_is_remarked(tmp_path: Path) -> None:
    part = {**PART, "joints": {"hip": {**JOINT, "parent": "body"}}}
    made = compiled_parts(tmp_path, parts={"leg": part}, use={"a": use()})
    (found,) = [found for found in made.diagnostics if found.rule == "ignored-key"]
    assert '"parent"' in found.message
    assert "mount" in found.message
    assert links(made) == ["a_leg", "body"]


def test_missing_argument_is_told_where_the_part_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    part = {**PART, "params": {"size": {"type": "length", "help": "of the foot"}}}
    made = compiled_parts(Path(), parts={"leg": part}, use={"a": use()})
    (found,) = made.diagnostics
    assert (found.rule, found.span and found.span.line) == ("missing-argument", 21)
    assert "of the foot" in found.help
    assert [one.span and one.span.line for one in found.related] == [17]


def test_file_of_a_package_is_shown_with_its_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "legs_of_acme"
    package.mkdir()
    (package / "__init__.py").write_text("", "utf-8")
    (package / "legs.yaml").write_text("parts: {leg: {linsk: {}}}\n", "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    made = compiled_parts(tmp_path, use={"a": use(part="legs_of_acme:legs/leg")})
    assert "legs_of_acme/legs.yaml:1:15: error[unknown-key]" in report(made.diagnostics)
    (package / "legs.yaml").write_text("prats: {leg: {}}\n", "utf-8")
    made = compiled_parts(tmp_path, use={"a": use(part="legs_of_acme:legs/leg")})
    assert 'legs_of_acme/legs.yaml:1:1: error[unknown-key]: legs_of_acme/legs.yaml has no key "prats"' in report(
        made.diagnostics
    )
