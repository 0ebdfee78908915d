"""Drawing: the tree of frames as text and as pictures.

To be read in this order: ``situations`` (which trees there are to show), ``terminal`` (one as text), ``svg`` and
``graphs`` (them as pictures). ``letters`` has widths and colours for all.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosorin_compile.model import Robot

    from .situations import Situation

# The ends of the file names of pictures.
SUFFIXES = (".svg", ".dot", ".gv", ".mmd", ".md")


def suffix(file: str) -> str:
    """Return the end of a file name that says which kind of picture it is; empty if it is none."""
    return next((end for end in SUFFIXES if file.casefold().endswith(end)), "")


def picture(robot: Robot, kind: str, shown: Sequence[Situation]) -> str:
    """Return situations as one picture; ``kind`` is one of SUFFIXES."""
    from rosorin_compile.model.frame_tree import lines, publishers, rows

    from .graphs import dot, markdown, mermaid
    from .letters import colours
    from .svg import Panel, svg

    writers = {".svg": svg, ".dot": dot, ".gv": dot, ".mmd": mermaid, ".md": markdown}
    names = robot.frames
    panels = [Panel(situation.label, lines(situation.edges, names)) for situation in shown]
    return writers[kind](robot.name, panels, colours(publishers(rows(robot))))
