"""Classic: what Gazebo classic says of a link in ``<mu1>`` and the like, as SDF says it of each collision.

They stand in a ``<gazebo reference>``, and the reader of URDF does the same with them
(``gazebosim/sdformat@sdf12:src/parser_urdf.cc``, InsertSDFExtensionCollision).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rosorin_compile.source.xml.markup import Element


class _Word(NamedTuple):
    """What a word is called in a <collision>, the part of its <surface> that it stands in, how many numbers it has."""

    name: str
    part: str = ""
    numbers: int = 1


OF_COLLISIONS: Mapping[str, _Word] = {
    "laserRetro": _Word("laser_retro"),
    "maxContacts": _Word("max_contacts"),
    "mu1": _Word("mu", "friction"),
    "mu2": _Word("mu2", "friction"),
    "fdir1": _Word("fdir1", "friction", 3),
    "kp": _Word("kp", "contact"),
    "kd": _Word("kd", "contact"),
    "maxVel": _Word("max_vel", "contact"),
    "minDepth": _Word("min_depth", "contact"),
}


def numbers_of(element: Element) -> str:
    """Return the numbers that a word for collisions says, as text or as its ``value``; empty if they are none."""
    words = (element.get("value") or element.text).split()
    try:
        finite = all(math.isfinite(float(word)) for word in words)
    except ValueError:
        return ""
    return " ".join(words) if finite and len(words) == OF_COLLISIONS[element.tag].numbers else ""


def of_collision(said: Mapping[str, str], own: Collection[str]) -> list[str]:
    """Return the elements of a collision for what is said of its link, by the words of Gazebo classic.

    ``own`` are the tags of what the collision says itself, which holds.
    """
    made, parts = list[str](), dict[str, str]()
    for word, (name, part, _) in OF_COLLISIONS.items():
        text = f"<{name}>{said[word]}</{name}>" if word in said else ""
        if text and part:
            parts[part] = parts.get(part, "") + text
        elif text and name not in own:
            made.append(text)
    surface = "".join(f"<{part}><ode>{inner}</ode></{part}>" for part, inner in parts.items())
    return [*made, f"<surface>{surface}</surface>"] if surface and "surface" not in own else made
