"""Wording: whatever stands in a file, what is said of it stands on one line and steers no terminal."""

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.source import wording
from rosorin_compile.source.diagnostics import did_you_mean
from rosorin_compile.source.wording import foreign, hidden_letter, look, mask_controls, phrase, printable, quote

TEXTS = st.text(st.characters(), max_size=20)  # lone surrogates too: names of files that are no text


@given(TEXTS)
def test_a_printable_text_is_one_line_of_what_a_terminal_shows(text):
    shown = printable(text)
    assert shown.isprintable()
    assert shown.encode("utf-8").decode("utf-8") == shown
    assert text.isprintable() == (shown == text)


@given(TEXTS)
def test_a_masked_text_is_as_long_as_the_text(text):
    assert len(mask_controls(text)) == len(text)
    assert mask_controls(text).isprintable()


def test_letters_that_may_stay():
    assert printable("a\tb\x1b\n", keep="\t") == "a\tb\\x1b\\n"
    assert mask_controls("a\tb\x1b\ufffe\udc80", keep="\t") == "a\tb???"


def test_rows_of_no_names_and_of_too_many():
    assert phrase([]) == "" == quote([])
    assert quote(["a", "b", "c"], 1) == '"a" and 2 more'


# Letters: what nobody sees is found, and what looks alike has one look, whatever form a file is written in.


NAMES = st.text(st.characters(exclude_categories=("Cs",)), min_size=1, max_size=12)


@given(NAMES)
def test_a_name_has_one_look_in_each_form(name):
    assert len({look(unicodedata.normalize(form, name)) for form in ("NFC", "NFD")}) == 1


@given(NAMES)
def test_what_is_printable_ascii_has_nothing_to_see(name):
    if name.isascii() and name.isprintable():
        assert hidden_letter(name) == foreign(name) == ""
    if not hidden_letter(name):
        categories = {unicodedata.category(letter) for letter in name}
        assert categories.isdisjoint(("Cc", "Cf", "Zl", "Zp"))


@pytest.mark.parametrize("name", ["größe", "перед", "μm", "joint_α", "左腕", "naïve", "Δθ", "robot_é"])
def test_names_in_letters_of_the_world_are_names(name):
    assert hidden_letter(name) == foreign(name) == ""


def test_every_look_alike_stands_for_a_latin_letter_or_a_dash():
    assert all(chr(code).isascii() and (chr(code).isalpha() or code == ord("-")) for code in wording.LATIN.values())
    assert not any(chr(code).isascii() for code in wording.LATIN)


@pytest.mark.parametrize(
    ("word", "says"),
    [
        ("b\u0430se_link", 'did you mean "base_link"? the two differ in U+0430 CYRILLIC SMALL LETTER A'),
        ("\u0432\u0430se_link", 'did you mean "base_link"?'),  # the first of its letters is like none of Latin
        ("base\u200b_link", 'did you mean "base_link"? the two differ in U+200B ZERO WIDTH SPACE, which is invisible'),
        ("Base_link", 'did you mean "base_link"?'),
    ],
)
def test_a_suggestion_says_what_nobody_can_see(word, says):
    assert did_you_mean(word, ["mast", "base_link"]) == says


def test_the_nearest_of_very_many_is_found_by_its_look():
    many = [f"joint_{index}" for index in range(200)]
    assert did_you_mean("j\u043eint_77", many).startswith('did you mean "joint_77"?')
