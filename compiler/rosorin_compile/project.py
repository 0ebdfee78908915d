"""The project: where descriptions and outputs stand on disk."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

ROOT_FILE = "robot.yaml"
DESCRIPTIONS = "descriptions"
OUTPUTS = "outputs"


class Description(NamedTuple):
    """A description that was asked for: its name, its first file, and the folder of its artifacts."""

    name: str
    path: Path
    outputs: Path


class NoDescription(Exception):
    """There is no description of that name; the message says what there is."""


def find(names: list[str], outputs: str | None) -> list[Description]:
    """Return the descriptions asked for by name, folder or file; without names all in ``descriptions/``.

    ``outputs`` is the folder that gets a folder a robot; by default ``outputs`` beside ``descriptions``.
    Raises NoDescription.
    """
    paths = [_path(name) for name in names] or all_here()
    if not paths:
        raise NoDescription(f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here; name a description, or go to its project")
    return [_description(path, outputs) for path in paths]


def all_here() -> list[Path]:
    """Return the first files of all descriptions of the project in this folder, sorted by name."""
    return sorted(Path(DESCRIPTIONS).glob(f"*/{ROOT_FILE}"))


def _path(name: str) -> Path:
    """Return the first file of a description given as a file, a folder or a name."""
    for path in (Path(name), Path(DESCRIPTIONS, name)):
        if path.is_dir() and (path / ROOT_FILE).is_file():
            return path / ROOT_FILE
    if Path(name).is_file():
        return Path(name)
    known = [path.parent.name for path in all_here()]
    from .diagnostic import did_you_mean

    help = did_you_mean(name, known) or f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here"
    raise NoDescription(f'no description "{name}": it is no file, no folder with {ROOT_FILE}, no name; {help}')


def _description(path: Path, outputs: str | None) -> Description:
    folder = Path(os.path.abspath(path)).parent
    name = folder.name if path.name == ROOT_FILE else path.stem
    if outputs is not None:
        base = Path(outputs)
    elif folder.parent.name == DESCRIPTIONS:
        base = _from_here(folder.parent.parent / OUTPUTS)
    else:
        base = Path(OUTPUTS)
    return Description(name, path, base / name)


def _from_here(path: Path) -> Path:
    """Return an absolute path relative to here if it is below, as a person would name it."""
    here = os.path.relpath(path)
    return path if here.startswith("..") else Path(here)
