"""The tool: an edited file of it is another one, whatever its size and times say; and so is what can be imported."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from rosorin_compile import world
from rosorin_compile.world.asking import note_tool
from rosorin_compile.world.disk import disk
from rosorin_compile.world.tool import signature
from support.commands import write_files


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


@pytest.mark.parametrize(
    ("files", "is_another"),
    [
        ({"MUJOCO_LOG.TXT": "a warning"}, False),
        ({"out/robot/robot.urdf": "<robot/>", "fleet.csv": ""}, False),
        ({"__pycache__/yaml.cpython-311.pyc": ""}, False),
        ({"yaml.py": ""}, True),
        ({"yaml/__init__.py": ""}, True),
        ({"yaml.cpython-311-x86_64-linux-gnu.so": ""}, True),
        ({"PyYAML-7.0.dist-info/METADATA": ""}, True),
        ({"more.pth": "elsewhere"}, True),
    ],
)
def test_what_appears_where_python_imports_from_counts_if_it_can_be_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: dict[str, str], is_another: bool
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "tool").mkdir()
    since = disk().now()
    before = signature(str(tmp_path / "tool"), since)
    write_files(tmp_path, files)
    assert (signature(str(tmp_path / "tool"), since) != before) is is_another


def test_another_path_of_python_is_another_tool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    noted = []
    for _ in range(2):
        world.tool_is([str(tmp_path)])
        with world.noting() as notes:
            note_tool()
        noted.append(notes.answers)
        monkeypatch.syspath_prepend(tmp_path)
    assert len(noted[0]) == 1
    assert noted[0].keys() == noted[1].keys()
    assert noted[0] != noted[1]
