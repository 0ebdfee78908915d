"""Wording: what all sentences share. Texts that cannot steer a terminal, counted things, and names in a row."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def printable(text: str, keep: str = "") -> str:
    r"""Return a text with control characters made visible, so that a file cannot steer the terminal.

    The letters of ``keep`` stay as they are, such as the tab in a line of a file.

    >>> printable("\x1b[31mred\n"), printable("1\t2", keep="\t") == "1\t2"
    ('\\x1b[31mred\\n', True)
    """
    plain = text
    for letter in keep:
        plain = plain.replace(letter, "")
    if plain.isprintable():
        return text
    return "".join(c if c.isprintable() or c in keep else c.encode("unicode_escape").decode("ascii") for c in text)


def inert(line: str) -> str:
    """Return a line in which a job on GitHub finds no command, whatever a robot is called.

    >>> inert("::error::##[x]")
    ': :error: :## [x]'
    """
    return line.replace("::", ": :").replace("##[", "## [")


def masked(text: str, keep: str = "") -> str:
    r"""Return a text with a question mark for each control character, for files that have no place for them.

    >>> masked("a\x07b\n", keep="\n")
    'a?b\n'
    """
    return "".join(c if c.isprintable() or c in keep else "?" for c in text)


def plural(noun: str, count: int) -> str:
    """Return a noun as it stands with a number.

    >>> plural("link", 2), plural("link", 1), plural("mesh", 0), plural("body", 2), plural("key", 2)
    ('links', 'link', 'meshes', 'bodies', 'keys')
    """
    if count == 1:
        return noun
    if noun.endswith("y") and noun[-2:-1] not in tuple("aeiou"):
        return f"{noun[:-1]}ies"
    return f"{noun}{'es' if noun.endswith(('s', 'x', 'sh', 'ch')) else 's'}"


def counted(count: int, noun: str) -> str:
    """Return a number of things in words.

    >>> counted(1, "edge"), counted(1200, "edge")
    ('1 edge', '1,200 edges')
    """
    return f"{count:,} {plural(noun, count)}"


def first_of(names: Sequence[str], most: int) -> str:
    """Return names in a row; of more than ``most`` the first ones and the number of the others.

    >>> first_of(["a", "b", "c"], 3), first_of(["a", "b", "c"], 1)
    ('a, b, c', 'a and 2 more')
    """
    return f"{', '.join(names[:most])}{and_more(len(names) - most)}"


def and_more(count: int, of: str = "") -> str:
    """Return the end of a sentence that names some things of many; nothing if none is left.

    >>> and_more(2), and_more(1, "of this kind"), and_more(0)
    (' and 2 more', ' and 1 more of this kind', '')
    """
    return f" and {count:,} more{f' {of}' if of else ''}" if count > 0 else ""


def listed(words: Iterable[str], most: int | None = None) -> str:
    """Return words as in a sentence; of more than ``most`` the first ones and the number of the others.

    >>> listed("abc"), listed("a"), listed("abc", most=2)
    ('a, b and c', 'a', 'a, b and 1 more')
    """
    every = list(words)
    if most is not None and len(every) > most:
        return first_of(every, most)
    *first, last = every or [""]
    return f"{', '.join(first)} and {last}" if first else last


def quoted(names: Iterable[str], most: int | None = None) -> str:
    """Return names in quotes, as in a sentence.

    >>> quoted(["a", "b", "c"])
    '"a", "b" and "c"'
    """
    return listed((f'"{name}"' for name in names), most)
