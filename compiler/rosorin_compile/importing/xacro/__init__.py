"""Xacro: expanded by the xacro library in a child process, and translated to a description with its macros.

``expand`` reads what the child process (``child``) expands as a URDF. ``translate`` keeps macros and arguments: the
child runs the file with symbols (``program``), builds an intermediate representation (``ir``) and returns the documents
of the description (``write_yaml``), which are compared with xacro. ``macros`` calls a macro of a vendor's file.
Nothing is imported here, because the child process imports this package too, and needs no reader.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.formats.format import Format, Opened

if TYPE_CHECKING:
    from rosorin_compile.formats.imported_robot import Imported
    from rosorin_compile.source.xml.markup import Document

__all__ = ["FORMAT"]


def _recognises(document: Document, path: Path) -> bool:
    from .expand import is_xacro

    defines_macros = any(child.tag == "xacro:macro" for child in document.root.children)
    return (document.root.tag == "robot" or defines_macros) and is_xacro(document, path)


def _read(opened: Opened) -> Imported:
    from .expand import read_xacro

    return read_xacro(opened.xml, opened.path, opened.options)


FORMAT = Format(
    name="xacro",
    word="xacro",
    article="a",
    rank=20,
    endings=(".xacro",),
    recognises=_recognises,
    load=_read,
    takes_arguments=True,
    becomes="urdf",
    folder="urdf",
)
