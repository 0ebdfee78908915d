"""Read back: what a description was compiled to becomes a robot again, to be held against the source of an import."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Format
from rosorin_compile.formats.gazebo_elements import element_differences, followers_of
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import join, read_robot
from rosorin_compile.model import Robot
from rosorin_compile.source.tree import Map

from .words.sensors import without_collisions


def read_back(stage: Path, said: Mapping[str, str], tree: Map, beside: Sequence[Format] = ()) -> Imported:
    """Return the robot that compiled texts say (by the names of their formats), which are written into a folder.

    It is that of the format that is published, with what the formats ``beside`` it add. ``tree`` is that of the source:
    what it may break, its copy may.
    """
    how = ReadOptions(lenient=True, checked=False)
    back = read_robot(_saved(stage, FORMATS.published(), said), how)
    for companion in beside:
        back = join(back, companion.name, _saved(stage, companion, said), how)
    if back.tree is not None and "accept" in tree:
        back.tree.put("accept", tree["accept"], back.tree.span, back.tree.span)
    return back


def _saved(stage: Path, format: Format, said: Mapping[str, str]) -> Path:
    """Return the file of a compiled artifact."""
    file = stage / f"compiled{format.endings[0]}"
    file.write_text(said[format.name], "utf-8")
    return file


def by_elements(source: Robot, again: Robot, made: Robot) -> list[str]:
    """Return how the elements of a robot that was read back differ from those of its source.

    ``made`` is the compiled description: its URDF has elements for Gazebo for the friction and springs of the source.
    """
    format, own = FORMATS.published(), list(source.urdf_elements)
    output = next((one for one in made.outputs if one.backend == format.name), None)
    if output is not None and format.brings is not None:
        own += format.brings(replace(source, sensors=(), control=(), controllers=()), output)
    texts = without_collisions(own), without_collisions(again.urdf_elements)
    return element_differences(*texts, followers_of(source, made.asks_for_humble))


def without_words(robot: Robot, source: Robot) -> Robot:
    """Return a robot that says in the words of its source what became other words."""
    return replace(
        robot,
        urdf_elements=source.urdf_elements,
        sensors=source.sensors,
        edges=source.edges,
        publishers=source.publishers,
        modes=source.modes,
        control=source.control,
        drive=source.drive,
    )
