"""Elements of XML in parts and sensors: the names in them follow their prefixes, and no value breaks them."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.language.element_names import rename_references
from rosorin_compile.source.xml.elements import damage, escape_for

VALUES = st.text(
    st.characters(codec="utf-8", exclude_characters="\x00\ufffe\uffff", exclude_categories=["Cs", "Cc"]), max_size=12
)


@given(VALUES)
def test_no_value_breaks_an_element(value):
    """What a reader of XML has is the very value, whatever signs are in it."""
    for before, after in (("<a b='", "'/>"), ('<a x="1" b="', '"/>'), ("<!-- <c d=' --><a b='", "'/>")):
        text = before + escape_for(before, value) + after
        assert damage(text) == ""
        assert ET.fromstring(f"<r>{text}</r>")[0].get("b") == value
    text = f"<a>{escape_for('<a>', value)}</a>"
    assert damage(text) == ""
    assert ET.fromstring(text).text in (value, value or None) or (len(ET.fromstring(text)) and not damage(value))
    for before, after in (("<a><!--", "--></a>"), ("<a><![CDATA[", "]]></a>")):
        assert damage(before + escape_for(before, value) + after) == ""


@pytest.mark.parametrize(
    ("before", "value", "fits"),
    [
        ("<a b='", "tab\tline\n", "tab&#9;line&#10;"),
        ("<a b='x' c=\"", "it's", "it&apos;s"),
        ("<a>", "<b/> and text", "&lt;b/&gt; and text"),
        ("<a>", " <b/> <c>1 &lt; 2</c> ", " <b/> <c>1 &lt; 2</c> "),
        ("<a>", "</a><a>", "&lt;/a&gt;&lt;a&gt;"),
        ("<a><!--", "a--b-", "a- -b- "),
        ("<a><!-- ' -->", "&", "&amp;"),
        ("<a><![CDATA[", "x]]>y & <z", "x]] >y & <z"),
        ("<a><![CDATA[ <b c=' ]]>", '"', '"'),
        ("<", "a&b", "a&b"),
        ("", "<b/>", "<b/>"),
    ],
)
def test_a_value_is_spelt_as_its_place_asks(before, value, fits):
    assert escape_for(before, value) == fits


def test_an_element_that_is_no_xml_is_not_renamed():
    text = '<gazebo reference="a"><b></gazebo>'
    assert rename_references(text, lambda name: f"x_{name}") == text


def test_all_that_is_renamed_is_a_name_letter_by_letter():
    text = "<gazebo reference = 'a'\n >\t<x>a</x> <parent_link> a </parent_link><!-- a --></gazebo>"
    text += "\n<gazebo reference='&#97;'/>"
    wanted = text.replace("'a'", "'x_a'").replace("> a </p", "> x_a </p")
    assert rename_references(text, lambda name: f"x_{name}") == wanted
