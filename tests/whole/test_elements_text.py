"""Elements of XML: one spelling of what is the same, and nothing that a depth or a declaration could break."""

import pytest

from rosorin_compile.source.xml.elements import canonical, tree_of


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("<a b='1' c='2'/>", '<a  c="2.0"\n b="1.000"></a>'),
        ("<a x='-0.0 1e-3'/>", "<a x='0 0.001'/>"),
        ("<a>one <b/> two</a>", "<a> one<!-- and -->\n<b></b>two </a>"),
        ("<sim:a b='1'/>", "<sim:a b='1.'/>"),
    ],
)
def test_what_differs_in_spelling_alone_is_the_same(one, other):
    assert canonical(tree_of(one)) == canonical(tree_of(other))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("<a b='1'/>", "<a b='1.0000001'/>"),
        ("<a><b/><c/></a>", "<a><c/><b/></a>"),
        ("<a><b><c/></b></a>", "<a><b/><c/></a>"),
        ("<a><b/>text</a>", "<a>text<b/></a>"),
        ("<a x='1_0'/>", "<a x='10'/>"),
        ("<a x='1&quot; y=&quot;2'/>", "<a x='1' y='2'/>"),
    ],
)
def test_what_says_something_else_is_not(one, other):
    assert canonical(tree_of(one)) != canonical(tree_of(other))


def test_no_depth_is_too_deep():
    deep = "<a>" * 50_000 + "</a>" * 50_000
    assert canonical(tree_of(deep)).startswith("<a><a>")


@pytest.mark.parametrize("text", ["", "<a>", "<a/><b/>", "<!DOCTYPE a><a/>", "<a>\ud800</a>"])
def test_what_is_no_tree_is_an_error(text):
    with pytest.raises(ValueError, match=r"."):
        tree_of(text)
