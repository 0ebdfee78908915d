"""Record: what an import wrote, kept as it was beside each file of a description: ``robot.yaml.imported``.

It is what the next import of the same source is held against: plain YAML, with the words of the import in the first
line of that of ``robot.yaml``. It belongs to the description, and goes with it into version control.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from rosorin_compile.extending import Description, world

ENDING = ".imported"
_PROGRAM = "# rosorin-compile import "


class Record(NamedTuple):
    """What an import before wrote: the words that it was given, and its files, text by name."""

    words: list[str]
    files: dict[str, str]


def of(files: Mapping[str, str], words: Iterable[str]) -> dict[str, str]:
    """Return the record of the files of a description, text by name."""
    made = {f"{name}{ENDING}": text for name, text in files.items()}
    listed = list(words)
    line = shlex.join(listed)
    first = f"{_PROGRAM}{line if line.isprintable() else json.dumps(listed)}\n"  # a name may be no text, or two lines
    return {
        name: f"{first}{text}" if name == f"{Description.ROOT_FILE}{ENDING}" else text for name, text in made.items()
    }


def is_of(name: str) -> bool:
    """Say whether a file is the record of another one."""
    return name.endswith(ENDING)


def read(folder: Path, others: Iterable[str] = ()) -> Record | None:
    """Return the record of the description in a folder; None if it has none, or a damaged one.

    ``others`` are names of files outside of the folder that may have one, too. Raises OSError.
    """
    try:
        first, end, root = text_of(folder / f"{Description.ROOT_FILE}{ENDING}").partition("\n")
        line = first.removeprefix(_PROGRAM)
        words = json.loads(line) if line.startswith("[") else shlex.split(line)
        names = [
            path.relative_to(folder).as_posix()
            for path in world.matching(folder, f"**/*{ENDING}")
            if world.kind(path) == world.FILE
        ]
        names += [f"{name}{ENDING}" for name in others if name.startswith("../")]
        texts = {name: text_of(folder / name) for name in names if world.kind(folder / name) == world.FILE}
    except (ValueError, FileNotFoundError, NotADirectoryError):
        return None
    files = {name.removesuffix(ENDING): text for name, text in texts.items()}
    return (
        Record(words, {**files, Description.ROOT_FILE: root}) if first.startswith(_PROGRAM) and end and words else None
    )


def text_of(path: Path) -> str:
    """Return a text with the line ends that it has. Raises OSError, ValueError."""
    return world.read(path).decode()
