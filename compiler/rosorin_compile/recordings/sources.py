"""Sources: what a recording is, told by its content, and the way from it to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import BinaryIO

import numpy as np

from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import Robot
from rosorin_compile.source import files

from .bags import BAGS, Progress, Unreadable, read
from .expected import Description, Options
from .judge import Verdict, judge
from .pasted import read_text
from .recording import Recording

STANDARD_INPUT = "-"
MAX_TEXT = 64 << 20


def verify(
    robot: Robot,
    artifacts: Sequence[Artifact],
    source: str,
    options: Options,
    progress: Progress = lambda done, all: None,  # noqa: A006, ARG005
    standard_input: Callable[[], bytes] = lambda: b"",
) -> Verdict:
    """Return how a recording compares with a robot and its compiled artifacts.

    ``source`` is a rosbag2 folder, one of its files, a text file, or "-" for text on standard input. Raises Unreadable.
    """
    description = Description(robot, options)
    with np.errstate(all="ignore"):  # a recording may hold any number; what is no number is told as such
        if source == STANDARD_INPUT:
            recording = _text(description, standard_input(), "standard input")
        else:
            recording = _file_or_folder(description, Path(source), progress)
        return Verdict(recording, description, judge(recording, artifacts))


def _file_or_folder(description: Description, path: Path, progress: Progress) -> Recording:
    try:
        if files.is_folder(path):
            return _bag(description, _parts(path), f"rosbag2 folder {path}", progress)
        if files.is_special(path) and not path.is_relative_to("/dev/fd"):
            raise Unreadable(f"{path} is not a regular file", "write it to a file first, or name - for standard input")
        if path.suffix in BAGS:
            return _bag(description, [path], str(path), progress)
        with _opened(path) as file:
            data = file.read(MAX_TEXT + 1)
    except FileNotFoundError:
        raise Unreadable(
            f"there is no {path}", "name a rosbag2 folder, a .mcap or .db3 file, a text file, or -"
        ) from None
    except OSError as wrong:
        raise Unreadable(f"{path} cannot be read: {wrong.strerror}") from None
    return _text(description, data, str(path))


def _opened(path: Path) -> BinaryIO:
    """Return a source to read from: a file, or a pipe of the shell as ``<(...)`` makes it. Raises OSError."""
    if files.is_special(path):
        return path.open("rb")
    return files.open_binary(path)


def _parts(folder: Path) -> list[Path]:
    """Return what rosbags reads of a folder: itself, or its files if metadata.yaml is missing. Raises Unreadable."""
    if files.is_file(folder / "metadata.yaml"):
        return [folder]
    bags = [path for path in files.list_folder(folder) if path.suffix in BAGS and files.is_file(path)]
    if bags:
        return bags
    inner = [path.parent.name for path in sorted(folder.glob("*/metadata.yaml"))]
    if inner:
        raise Unreadable(f"{folder} holds several recordings: {', '.join(inner[:5])}", "name one of them")
    raise Unreadable(
        f"{folder} is no recording: it has no metadata.yaml, no .mcap and no .db3", "name a rosbag2 folder"
    )


def _bag(description: Description, paths: Sequence[Path], form: str, progress: Progress) -> Recording:
    recording = Recording(description, form)
    recording.whole = True
    read(paths, recording, progress)
    return recording


def _text(description: Description, data: bytes, name: str) -> Recording:
    """Return what a text says. Raises Unreadable."""
    if len(data) > MAX_TEXT:
        raise Unreadable(f"{name} is larger than any pasted text ({MAX_TEXT >> 20} MiB)", "record a bag instead")
    if b"\0" in data:
        raise Unreadable(
            f"{name} is neither a rosbag2 recording nor a text", "name a folder, a .mcap, a .db3 or a text"
        )
    recording = Recording(description, f"text in {name}")
    recording.timed = False
    read_text(data.decode("utf-8", "replace"), recording)
    recording.finish()
    return recording
