"""Holding copies against what is compiled: by meaning first, then as text."""

from __future__ import annotations

import dataclasses
import posixpath
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rosorin_compile.compare.changes import Change
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output.committed import TextDifference, compare, shorten
from rosorin_compile.source.diagnostics import printable

from .meshes import settle

_SAME = "same meaning, different text"


class Difference(NamedTuple):
    """How a file differs from what is compiled: in words, and what these are made of.

    ``changes`` are those of meaning, ``texts`` the difference of text, the first of them with a unified diff.
    """

    meaning: tuple[str, ...]
    changes: tuple[Change, ...]
    texts: tuple[TextDifference, ...]

    def lines(self, place: str, full: bool) -> list[str]:
        """Return the difference as lines of plain text, each change with the place of the file before it."""
        lines = [f"{printable(place)}: {line}" for line in self.meaning]
        return lines + [line for one in self.texts[:1] for line in (one.lines if full else shorten(one.lines))]


def placed(robot: Robot, artifact: Artifact, place: str, urdf: str) -> Artifact:
    """Return an artifact as it is for a place: the launch file looks for the URDF where that is (relative names)."""
    if not FORMATS[artifact.backend].located or not urdf:
        return dataclasses.replace(artifact, file=place)
    urdfs = [output.name for output in FORMATS.feeding(robot, ROBOT_STATE_PUBLISHER)]
    names = {**dict.fromkeys(urdfs, urdf), artifact.output: place}
    moved = tuple(dataclasses.replace(output, file=names.get(output.name, output.file)) for output in robot.outputs)
    there = dataclasses.replace(robot, outputs=moved)
    output = next(output for output in moved if output.name == artifact.output)
    text = FORMATS[artifact.backend].written(there, output, Templates())[0]
    return dataclasses.replace(artifact, file=place, text=text)


def forms(robot: Robot, artifact: Artifact, place: str, urdfs: Iterable[str], package: str) -> list[Artifact]:
    """Return every form in which a copy at ``place`` is as compiled, the most likely one first.

    A launch file may look for any of the ``urdfs``; a URDF may name its meshes in ``package``.
    """
    near = sorted(urdfs, key=lambda urdf: (len(posixpath.relpath(urdf, posixpath.dirname(place) or ".")), urdf))
    copies = [placed(robot, artifact, place, urdf) for urdf in near] if FORMATS[artifact.backend].located else []
    if FORMATS.names_meshes(artifact) and package:
        from pathlib import Path

        settled = settle(artifact.text, package, (), Path(posixpath.dirname(place) or "."))
        if settled.text != artifact.text:
            copies.append(dataclasses.replace(artifact, file=place, text=settled.text))
    return [*copies, dataclasses.replace(artifact, file=place)]


def difference(robot: Robot, artifact: Artifact, old: bytes) -> Difference | None:
    """Return how the bytes of a copy differ from an artifact; None if they do not."""
    if old == artifact.text.encode():
        return None
    comparison = compare(robot, [artifact], {artifact.file: old})
    meaning = [change.text for change in comparison.changes]
    texts = tuple(map(_deployed, comparison.texts))
    meaning += [text.remark for text in texts if text.remark]
    return Difference(tuple(meaning) or (_SAME,), comparison.changes, texts)


def _deployed(text: TextDifference) -> TextDifference:
    """Return a difference of text as it is said of a copy."""
    if not text.is_text:
        return text._replace(remark="no UTF-8 text")
    return text._replace(remark=text.remark.replace("the committed file", "the file"), lines=_headed(text.lines))


def _headed(lines: Sequence[str]) -> tuple[str, ...]:
    """Return a diff whose first line says that the old text is the deployed one."""
    return tuple(line.replace("--- committed/", "--- deployed/", 1) if i == 0 else line for i, line in enumerate(lines))
