"""Wording: whatever stands in a file, what is said of it stands on one line and steers no terminal."""

from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.source.wording import listed, masked, printable, quoted

TEXTS = st.text(st.characters(), max_size=20)  # lone surrogates too: names of files that are no text


@given(TEXTS)
def test_a_printable_text_is_one_line_of_what_a_terminal_shows(text):
    shown = printable(text)
    assert shown.isprintable()
    assert shown.encode("utf-8").decode("utf-8") == shown
    assert text.isprintable() == (shown == text)


@given(TEXTS)
def test_a_masked_text_is_as_long_as_the_text(text):
    assert len(masked(text)) == len(text)
    assert masked(text).isprintable()


def test_letters_that_may_stay():
    assert printable("a\tb\x1b\n", keep="\t") == "a\tb\\x1b\\n"
    assert masked("a\tb\x1b\ufffe\udc80", keep="\t") == "a\tb???"


def test_rows_of_no_names_and_of_too_many():
    assert listed([]) == "" == quoted([])
    assert quoted(["a", "b", "c"], 1) == '"a" and 2 more'
