"""Elements, text and files of XML, beside ``Document`` and ``Element``, which are public."""

from __future__ import annotations

from ..xml.elements import canonical, found_in, indented, tree_of
from ..xml.escaping import Markup, escape
from ..xml.files import mended, printable_name, read_source
from ..xml.imu import with_noise
from ..xml.markup import COMMENT, TEXT, Attribute, Word, parse

__all__ = [
    "COMMENT",
    "TEXT",
    "Attribute",
    "Markup",
    "Word",
    "canonical",
    "escape",
    "found_in",
    "indented",
    "mended",
    "parse",
    "printable_name",
    "read_source",
    "tree_of",
    "with_noise",
]
