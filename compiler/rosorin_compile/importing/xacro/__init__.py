"""Read xacro files: expand them with the xacro library, or translate them to a description with parts and arguments.

``expand`` expands a file in a child process (``child``) and reads the result as URDF. ``translate`` keeps macros and
arguments: the child process executes the file symbolically (``program``), builds an intermediate representation
(``ir``) and returns the description (``write_yaml``), which is compared with the output of xacro. ``macros`` generates
the xacro for calling a vendor's macro. This module imports almost nothing, so that the child process starts fast.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.formats.format import Format, ImportFile

if TYPE_CHECKING:
    from rosorin_compile.formats.imported_robot import ImportedRobot
    from rosorin_compile.source.xml.markup import Document

__all__ = ["FORMAT"]


def _recognises(document: Document, path: Path) -> bool:
    from .expand import is_xacro

    defines_macros = any(child.tag == "xacro:macro" for child in document.root.children)
    return (document.root.tag == "robot" or defines_macros) and is_xacro(document, path)


def _read(opened: ImportFile) -> ImportedRobot:
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
