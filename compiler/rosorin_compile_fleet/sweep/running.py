"""Running: all variants of a list in their order, made by an engine or known already, and the index of them.

No more than some hundreds of results wait for their turn, however many variants there are.
"""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Container, Iterable, Iterator
from typing import NamedTuple

from rosorin_compile import Variant, __version__
from rosorin_compile.diagnostics import Diagnostic, Progress

from .engines import Engine
from .folder import Index
from .making import ERROR, MADE, UNCHANGED, Folder, Made
from .remote import RemoteIndex

WAITING = 1_000  # variants between the first that is not done and the last that is begun
_RECENT = 20.0  # seconds that the rate is of


class Stopped(Exception):
    """Nothing more can be written; carries why."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class Counts:
    """How many variants came out how, and how long that took."""

    def __init__(self, total: int) -> None:
        self.total = total
        self.by_state = {MADE: 0, UNCHANGED: 0, ERROR: 0}
        self.size = 0
        self.edited = 0
        self.made_of: set[str] = set()
        self.begun = time.monotonic()
        self.recent: deque[tuple[float, int]] = deque()

    @property
    def worked(self) -> int:
        """How many variants were made in this run, or tried."""
        return self.by_state[MADE] + self.by_state[ERROR]

    @property
    def seconds(self) -> float:
        """How long the run takes already."""
        return time.monotonic() - self.begun

    @property
    def done(self) -> int:
        """How many variants are done."""
        return sum(self.by_state.values())

    def count(self, made: Made) -> None:
        """Count a variant."""
        self.by_state[made.state] += 1
        self.size += made.size
        self.edited += made.edited
        if made.made_of and len(self.made_of) < WAITING:
            self.made_of.add(made.made_of)

    def show(self) -> None:
        """Show how far it is, how fast, and how long it will take."""
        now, worked = time.monotonic(), self.worked
        if not self.recent or now - self.recent[-1][0] > 0.5:
            self.recent.append((now, worked))
        while len(self.recent) > 2 and now - self.recent[0][0] > _RECENT:
            self.recent.popleft()
        since, before = self.recent[0]
        rate = (worked - before) / (now - since) if now > since else 0.0
        more = f" {_rate(rate)}, {duration((self.total - self.done) / rate)} left" if rate else ""
        Progress.step("variants", self.done, self.total, more=more)


def _rate(rate: float) -> str:
    return f"{rate:.1f}/s" if rate >= 1 else f"{60 * rate:.1f}/min"


def duration(seconds: float) -> str:
    """Return a time as a person says it.

    >>> duration(59.4), duration(61), duration(7300), duration(200_000)
    ('59 s', '1 min', '2 h 1 min', '2 d 7 h')
    """
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = int(seconds // 60)
    if minutes < 60:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours < 48 else f"{hours // 24} d {hours % 24} h"


class Asked(NamedTuple):
    """What a run is asked for: the variants, what is known of one, and who makes it."""

    variants: Iterable[Variant]
    known: Callable[[Variant], Made | None]
    engine: Engine
    changing: Callable[[], None]


def in_order(asked: Asked) -> Iterator[Made]:
    """Yield what became of each variant, in their order. ``changing`` is called before anything changes."""
    waiting: dict[int, Made] = {}
    turn = begun = 0
    changed = False
    rest, at_work, more = iter(asked.variants), 0, True
    while more or at_work or waiting:
        while more and asked.engine.room and begun - turn < WAITING and len(waiting) < WAITING:
            variant = next(rest, None)
            if variant is None:
                more = False
                break
            made = asked.known(variant)
            if made is not None:
                waiting[begun] = made
            else:
                if not changed:
                    asked.changing()
                changed = True
                asked.engine.submit(begun, variant)
                at_work += 1
            begun += 1
            if turn in waiting:
                break
        if at_work and turn not in waiting:
            for index, made in asked.engine.results():
                waiting[index] = made
                at_work -= 1
        while turn in waiting:
            made = waiting.pop(turn)
            turn += 1
            yield made


def run(
    asked: Asked, index: Index | RemoteIndex, counts: Counts, told: Callable[[Made], None], head: dict[str, object]
) -> None:
    """Make all variants, write the index, and count. Raises Stopped, OSError, LoadError."""
    text = json.dumps({"sweep": 1, "tool": __version__, **head})
    index.write(f'{text[:-1]}, "variants": [\n')
    for number, made in enumerate(in_order(asked)):
        if made.fatal is not None:
            raise Stopped(made.fatal)
        index.write((",\n" if number else "") + made.line)
        counts.count(made)
        counts.show()
        told(made)
    index.write("\n]}\n")


def forgotten(folder: Folder, variants: Container[str]) -> Iterator[str]:
    """Yield the names of variants that the folder has and the list has no more."""
    return (name for name in folder.names() if name not in variants)
