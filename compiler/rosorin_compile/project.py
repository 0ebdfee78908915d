"""The project: where descriptions and outputs stand on disk."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

ROOT_FILE = "robot.yaml"
ENDINGS = (".yaml", ".yml")
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
    paths = [first_file(name) for name in names] or all_here()
    if not paths:
        raise NoDescription(f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here; name a description, or go to its project")
    return [_description(path, outputs) for path in paths]


def all_here() -> list[Path]:
    """Return the first files of all descriptions of the project in this folder, sorted by name."""
    return sorted(Path(DESCRIPTIONS).glob(f"*/{ROOT_FILE}"))


def first_file(name: str) -> Path:
    """Return the first file of a description given as a file, a folder or a name. Raises NoDescription."""
    for path in (Path(name), Path(DESCRIPTIONS, name)):
        if is_file(path / ROOT_FILE):
            return path / ROOT_FILE
    if is_file(Path(name)):
        return Path(name)
    known = [path.parent.name for path in all_here()]
    from .diagnostic import did_you_mean

    help = did_you_mean(name, known) or f"there is no {DESCRIPTIONS}/*/{ROOT_FILE} here"
    raise NoDescription(f'no description "{name}": it is no file, no folder with {ROOT_FILE}, no name; {help}')


def is_file(path: Path) -> bool:
    """Say whether there is a file; there is none of a name that no file can have."""
    return os.path.isfile(path)  # noqa: PTH113 - Path.is_file raises for such a name


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
