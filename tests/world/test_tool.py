"""The tool: an edited file of it is another tool, whatever its size and times say."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rosorin_compile.world.disk import disk
from rosorin_compile.world.tool import signature


def edited(folder: Path) -> None:
    file = folder / "inner" / "module.py"
    before = file.stat()
    file.write_text("VALUE = 2\n")
    os.utime(file, ns=(before.st_atime_ns, before.st_mtime_ns))


@pytest.mark.parametrize(
    ("change", "is_another"),
    [
        (lambda _: None, False),
        (edited, True),
        (lambda folder: (folder / "table.json").write_text("[]"), True),
        (lambda folder: (folder / "inner" / "__init__.py").unlink(), True),
        (lambda folder: (folder / "inner" / "__pycache__" / "module.pyc").write_bytes(b"1"), False),
    ],
)
def test_an_edited_file_is_another_tool(tmp_path: Path, change: Callable[[Path], object], is_another: bool) -> None:
    inner = tmp_path / "inner"
    (inner / "__pycache__").mkdir(parents=True)
    (inner / "__init__.py").write_text("")
    (inner / "module.py").write_text("VALUE = 1\n")
    signed, since = signature, disk().now()
    before = signed(str(tmp_path), since)
    change(tmp_path)
    assert (signed(str(tmp_path), since) != before) is is_another
