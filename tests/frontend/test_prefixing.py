"""Names in kept elements of a robot that is brought in get its prefix: those of its materials, links and joints."""

from __future__ import annotations

from collections import Counter

import pytest

from rosorin_compile.frontend.expand.prefixing import _Renamer


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
    changed = Counter[str]()
    assert _Renamer("left_", {"arm"}, {"grey"}, changed).elements(text) == renamed
    assert sum(changed.values()) == renamed.count("left_")
