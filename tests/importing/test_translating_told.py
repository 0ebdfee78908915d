"""What is told of a translation: how many macros are kept, and in what the rest differs."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.importing.xacro.translate import translation_report
from rosorin_compile.importing.xacro.values import Values
from rosorin_compile.importing.xacro.verify import difference
from rosorin_compile.source.xml.elements import tree_of

from .test_translating_texts import of

pytest.importorskip("xacro")

ODD = "${list(map(lambda x: x, ['odd']))[0]}"
LINK = '<link name="base"/>'


def chain(name: str, child: str = "") -> str:
    joint = f'<joint name="{name}_j" type="fixed"><parent link="base"/><child link="{child or name}"/></joint>'
    return f'<link name="{name}"/>{joint}'


def macro(name: str, params: str, body: str) -> str:
    return f'<xacro:macro name="{name}" params="{params}">{body}</xacro:macro>'


def test_elements_are_not_counted_as_macros(tmp_path: Path) -> None:
    wheel = macro("wheel", "p", chain("${p}wheel")) + '<xacro:wheel p="l_"/>'
    made = of(tmp_path, LINK + wheel + chain(ODD, "odd"))
    lines = list(translation_report(made))
    assert lines[:2] == ["1 of 1 macro kept", "as xacro expands them: 2 elements"]
    assert lines[2].startswith(f'  <link name="{ODD}">: lambda x: x cannot be translated (robot.xacro:')
    made = of(tmp_path, f'<link name="{ODD}"/>')
    assert next(translation_report(made)) == "as xacro expands it: 1 element"


def test_what_is_called_by_what_is_written_out_is_not_idle(tmp_path: Path) -> None:
    body = macro("inner", "p", chain("${p}", "odd")) + macro("outer", "p *o", '<xacro:inner p="${p}"/>')
    body += macro("alone", "", LINK) + macro("of_alone", "", LINK) + macro("other", "", "<xacro:of_alone/>")
    lines = list(translation_report(of(tmp_path, LINK + body + f'<xacro:outer p="{ODD}"><x/></xacro:outer>')))
    assert lines[0] == "0 of 2 macros kept, 2 written out where they are called"
    assert "  inner: what calls it is written out (robot.xacro:1)" in lines
    assert "left out, because nothing calls them: alone, of_alone and other" in lines


def test_a_macro_that_is_defined_within_a_link_is_kept(tmp_path: Path) -> None:
    shape = '<visual><geometry><sphere radius="${r}"/></geometry></visual>'
    body = f'<link name="base">{macro("ball", "r", shape)}<xacro:ball r="0.1"/></link>'
    lines = list(translation_report(of(tmp_path, body)))
    assert lines[0] == "1 of 1 macro kept"


HARDWARE = (
    "<ros2_control name='x'><hardware><param name='mock'>{}</param><param name='n'>1</param></hardware></ros2_control>"
)
DIFFERENCES = [
    (
        HARDWARE.format("False"),
        HARDWARE.format("false"),
        'hardware/param "mock": xacro has False, the translation false',
    ),
    ("<a><b c='1'/></a>", "<a><b/></a>", "b/@c: xacro has 1, the translation nothing"),
    ("<a><b/><c/></a>", "<a><b/></a>", "xacro has <c>, the translation nothing"),
    ("<a><b/></a>", "<a><d name='e'/></a>", 'xacro has <b>, the translation <d name="e">'),
]


@pytest.mark.parametrize(("one", "other", "said"), DIFFERENCES)
def test_what_differs_in_elements(one: str, other: str, said: str) -> None:
    assert difference(tree_of(one), tree_of(other)) == said


def test_a_reason_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Elements that differ are told by where, not whole."""
    right = Values.element

    def wrong(self, node):  # type: ignore[no-untyped-def]
        return type(made := right(self, node))(str(made).replace("slow/", "fast/"))

    monkeypatch.setattr(Values, "element", wrong)
    many = "".join(f'<param name="p{number}">{number}</param>' for number in range(99))
    body = f'<ros2_control name="x"><hardware><plugin>slow/Slow</plugin>{many}</hardware></ros2_control>'
    made = of(tmp_path, macro("control", "", body) + LINK + "<xacro:control/>")
    reason = made.reason or made.written_out[0].reason.removeprefix("not proven: ")
    assert reason == '<ros2_control name="x">: hardware/plugin: xacro has slow/Slow, the translation fast/Slow'
