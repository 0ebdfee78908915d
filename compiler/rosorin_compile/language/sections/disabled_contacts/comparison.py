"""What differs in the pairs of links that may touch."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.compare.difference import OTHER, Item, Side
from rosorin_compile.compare.pairing import Pairing
from rosorin_compile.compare.wording import contacts_change

from . import DISABLED_CONTACTS

AFTER = "rest"


def compare(pairing: Pairing, _: tuple[Side, Side]) -> Iterator[Item]:
    """Yield the pairs that are new or gone, as one difference."""
    robots = pairing.a.robot, pairing.b.robot
    old, new = ({" - ".join(sorted(pair)) for pair in robot.sections[DISABLED_CONTACTS]} for robot in robots)
    if old != new:
        text = contacts_change(sorted(new - old), sorted(old - new)).text
        yield Item(OTHER, "contacts", "contacts", text, ", ".join(sorted(old)), ", ".join(sorted(new)))
