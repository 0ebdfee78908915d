"""Names in kept elements of a robot that is brought in get its prefix: those of its materials, links and joints."""

from __future__ import annotations

import pytest

from rosorin_compile.language.expand.included_robots import prefixed
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.tree import Instance


@pytest.mark.parametrize(
    ("text", "renamed"),
    [
        ('<visual><material name="grey"/></visual>', '<visual><material name="left_grey"/></visual>'),
        ('<visual><material name="arm"/></visual>', '<visual><material name="arm"/></visual>'),
        ('<contact link="arm"/>', '<contact link="left_arm"/>'),
        ('<contact link="grey"/>', '<contact link="grey"/>'),
        ("<x><link>arm</link><link>grey</link></x>", "<x><link>left_arm</link><link>grey</link></x>"),
    ],
)
def test_names_of_its_own_get_the_prefix(text: str, renamed: str) -> None:
    tree = parse_yaml(Source("r.yaml", f"materials: {{grey: {{}}}}\nlinks: {{arm: {{}}}}\nurdf_elements: ['{text}']\n"))
    made, changed = prefixed(tree, "left_", Instance("included", tree.span))
    assert made["urdf_elements"] == [renamed]
    assert sum(changed.values()) == renamed.count("left_")


def test_materials_of_its_own_get_the_prefix_where_they_are_used() -> None:
    text = "materials: {grey: {}, left_grey: {}}\nlinks: {arm: {visual: [{material: grey}, {material: arm}]}}\n"
    tree = parse_yaml(Source("robot.yaml", text))
    made, _ = prefixed(tree, "left_", Instance("included", tree.span))
    assert list(made["materials"]) == ["left_grey", "left_left_grey"]
    assert made["links"]["left_arm"] == {"visual": [{"material": "left_grey"}, {"material": "arm"}]}
