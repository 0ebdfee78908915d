"""Robots of others, as packages of PyPI carry them: where they are, and what is done with each as a person would.

``.ci/full robots`` installs the packages into the folder ROBOTS, each into one of its own, without what it depends on.
"""

from __future__ import annotations

import os
import re
import shlex
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown
from support.round_trip import utf8

ROBOTS = Path(os.environ["ROBOTS"]) if os.environ.get("ROBOTS") else None
NONE = "(none)"  # the name of a file where there are none, so that a tier without its robots fails


def names(ending: str, *packages: str) -> list[str]:
    """Return the files of packages that end so, by their names below ROBOTS."""
    if ROBOTS is None:
        return [NONE]
    found = [path for package in packages for path in (ROBOTS / package).rglob(f"*{ending}")]
    return sorted(path.relative_to(ROBOTS).as_posix() for path in found) or [NONE]


def short(name: str) -> str:
    """Return what a test calls a robot: its package and its file."""
    return f"{name.partition('/')[0]}/{name.rpartition('/')[2]}"


def file_of(name: str) -> Path:
    """Return the file of a robot."""
    if ROBOTS is None or name == NONE:
        pytest.fail("ROBOTS has no such files: .ci/full robots puts them there")
    return ROBOTS / name


class Brought(NamedTuple):
    """What became of a robot: exit codes of ``import`` and of the line that it says next, and all that was said.

    ``outputs`` is the folder of the artifacts, ``codes`` has one entry where import refuses.
    """

    codes: tuple[int, ...]
    said: str
    next: str
    outputs: Path

    def artifact(self, ending: str) -> Path:
        """Return the artifact that ends so."""
        (found,) = self.outputs.rglob(f"*{ending}")
        return found


def bring(source: Path, capsys: Shown, *words: str) -> Brought:
    """Import a robot into the current folder, then run exactly the line that import says next."""
    code = main(["import", str(source), *words])
    shown = capsys.readouterr()
    said = shown.out + shown.err
    if code:
        return Brought((code,), said, "", Path())
    (line,) = re.findall(r"(?m)^next: rosorin-compile (.*)$", shown.out)
    command, folder, *more = shlex.split(line)
    again = main([command, folder, *more])
    shown = capsys.readouterr()
    return Brought((code, again), said + shown.out + shown.err, line, Path("outputs", Path(folder).name))


def text_of(source: Path) -> bytes:
    """Return a URDF as XML in UTF-8, that of a xacro as xacro makes it."""
    data = source.read_bytes()
    if b"<xacro:" not in data:
        return utf8(data)
    import xacro

    return utf8(xacro.process_file(str(source)).toxml("utf-8"))


def meshes(urdf: bytes, robot: Path) -> dict[tuple[str, str, int], tuple[str, Path | None]]:
    """Return the meshes of the shapes of a URDF, by link, visual or collision, and number: the name and the file.

    The file is that which the tools of ROS find from the file of the ``robot``; None where it is not there.
    """
    found = {}
    for link in ET.fromstring(urdf).findall("link"):
        for kind in ("visual", "collision"):
            for number, solid in enumerate(link.findall(kind)):
                mesh = solid.find("geometry/mesh")
                if mesh is not None:
                    name = mesh.get("filename", "")
                    file = next((path for path in _candidates(name, robot) if path.is_file()), None)
                    found[link.get("name", ""), kind, number] = (name, file)
    return found


def _candidates(name: str, robot: Path) -> Iterator[Path]:
    scheme, mark, rest = name.partition("://")
    if not mark:
        yield robot.parent / name
    elif scheme == "file":
        yield Path(rest)
    else:
        package, _, path = rest.lstrip("/").partition("/")
        yield from (folder / path for folder in _packages(package, robot.absolute()))


def _packages(name: str, robot: Path) -> Iterator[Path]:
    """Yield the folders around a robot that are a package: by what their package.xml says, or by their own names."""
    for folder in robot.parents:
        manifest = folder / "package.xml"
        if folder.name == name or (manifest.is_file() and f"<name>{name}</name>" in manifest.read_text("utf-8")):
            yield folder
        if (folder / name).is_dir():
            yield folder / name


def skip_without_judges() -> None:
    """Skip a test where an engine that judges is not installed."""
    for engine in ("mujoco", "pinocchio", "yourdfpy"):
        pytest.importorskip(engine)
