"""How many lines of each room the quick tests run, as a table that is kept."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

KEPT = Path(__file__).with_name("coverage.txt")
LOOSE = "(modules beside the rooms)"
SLACK = 0.5  # percent: tests that run side by side do not run the same lines each time


class Room(NamedTuple):
    """The lines of a room that can run, and those that a test ran."""

    lines: int
    run: int

    @property
    def percent(self) -> float:
        """The lines that ran, of a hundred."""
        return 100 * self.run / max(1, self.lines)


def measured(data: Path, packages: Iterable[Path]) -> dict[str, Room]:
    """Return rooms by name, from a file that coverage wrote: those of the first package, and each other one as one."""
    from coverage import Coverage

    known = Coverage(data_file=str(data))
    known.load()
    rooms: dict[str, Room] = {}
    core, *others = packages
    named = [(path, _room(path.relative_to(core))) for path in sorted(core.rglob("*.py"))]
    named += [(path, other.name) for other in others for path in sorted(other.rglob("*.py"))]
    for path, name in named:
        _, lines, _, missed, _ = known.analysis2(str(path))
        before = rooms.get(name, Room(0, 0))
        rooms[name] = Room(before.lines + len(lines), before.run + len(lines) - len(missed))
    return rooms


def _room(path: Path) -> str:
    first, *inner = path.parts
    return first if inner else LOOSE


def text(rooms: Mapping[str, Room]) -> str:
    """Return rooms as the table that is kept."""
    rows = [f"{room.lines} {room.run} {room.percent:.1f} {name}" for name, room in sorted(rooms.items())]
    return "".join(f"{row}\n" for row in ("# lines run percent room", *rows))


def kept(table: str) -> dict[str, Room]:
    """Return the rooms of a table."""
    rows = (line.split(" ", 3) for line in table.splitlines() if not line.startswith("#"))
    return {name: Room(int(lines), int(run)) for lines, run, _, name in rows}


def fewer(before: Mapping[str, Room], now: Mapping[str, Room]) -> Iterator[str]:
    """Yield the rooms of which tests run less than before, or of which nothing is kept."""
    for name, room in sorted(now.items()):
        if name not in before:
            yield f"{name}: quick tests run {room.percent:.1f} % of its lines, and no figure is kept: --coverage"
        elif room.percent < before[name].percent - SLACK:
            yield f"{name}: quick tests run {room.percent:.1f} % of its lines, {before[name].percent:.1f} % before"
