"""Text of XML: what is XML already, and how other text becomes so.

As markupsafe has it, which Jinja comes with, and which takes 4 ms to import; it understands ``__html__``, too.
"""

from __future__ import annotations

from typing import Any


class Markup(str):
    """Text that is XML already."""

    __slots__ = ()

    def __html__(self) -> Markup:
        """Return the text itself, as whoever escapes it asks for."""
        return self


def escape(value: Any) -> Markup:
    """Return a value as text of XML, for between tags and for in quotes of both kinds.

    >>> escape("a < 'b'"), escape(Markup("<b/>"))
    ('a &lt; &#39;b&#39;', '<b/>')
    """
    if value.__class__ is Markup:
        return value
    if value.__class__ is str and value.isidentifier():  # as most names are
        return Markup(value)
    if hasattr(value, "__html__"):
        return Markup(value.__html__())
    text = str(value).replace("&", "&amp;").replace(">", "&gt;").replace("<", "&lt;")
    return Markup(text.replace("'", "&#39;").replace('"', "&#34;"))
