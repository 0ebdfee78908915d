"""Looks: a colour for each link, and visuals for links that have collision shapes alone.

Nobody has said these colours: they are no facts about a robot. The page and pictures have them too, so that a robot
looks the same wherever it is shown.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from colorsys import hls_to_rgb, rgb_to_hls
from dataclasses import replace
from typing import TYPE_CHECKING

from .cached import of_robot
from .link import Link
from .shape import Material, Rgba

if TYPE_CHECKING:
    from .robot import Robot

# Degrees from a hue to the one that is tried next: 360 times the golden ratio, so that no two come close.
_GOLDEN_ANGLE = 137.50776
_NEAR = 25.0  # degrees: hues of a link and of what it hangs on are farther apart
_LIGHT, _DARK, _SATURATION, _GREY = 0.60, 0.52, 0.42, 0.10
_DIGITS = 3
_ROUNDED = 0.01  # what rounding to three digits makes of lightness and saturation, at most


@of_robot
def own_colours(robot: Robot) -> Mapping[str, Rgba]:
    """Return a colour for each link, by its name: calm, a function of that name, and not near that of its parent.

    Where it would be, the child moves on. So a link that is added leaves all others as they are, but those behind it.
    """
    hues: dict[str, float] = {}
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        hue = _number(link.name) % 3600 / 10
        while above is not None and abs((hue - hues[above.parent] + 180) % 360 - 180) < _NEAR:
            hue = (hue + _GOLDEN_ANGLE) % 360
        hues[link.name] = hue
    return {name: _calm(name, hue) for name, hue in hues.items()}


def _number(name: str) -> int:
    """Return a number for a name: the same on every machine, and for names that differ in a letter far apart."""
    return (zlib.crc32(name.encode("utf-8", "surrogatepass")) * 2_654_435_761 >> 8) & 0xFFFFFF


def _calm(name: str, hue: float) -> Rgba:
    """Return a colour of that hue for a link; what is called a base is large, as a rule, and grey."""
    light, saturation = _DARK if _number(name) // 3600 % 2 else _LIGHT, _GREY if "base" in name else _SATURATION
    red, green, blue = hls_to_rgb(round(hue, 1) / 360, light, saturation)
    return (round(red, _DIGITS), round(green, _DIGITS), round(blue, _DIGITS), 1.0)


def is_own(rgba: Sequence[float]) -> bool:
    """Say whether a colour looks like one that links are given, now or when they went by the number of a link."""
    if len(rgba) != 4 or rgba[3] != 1.0 or not all(0 <= part <= 1 for part in rgba):
        return False
    _, light, saturation = rgb_to_hls(*rgba[:3])
    lights, saturations = (_LIGHT, _DARK), (_SATURATION, _GREY)
    return min(abs(light - one) for one in lights) < _ROUNDED > min(abs(saturation - one) for one in saturations)


def colours_of(robot: Robot) -> dict[str, Material]:
    """Return a colour for each link that has collision shapes and no visual, by its name.

    They are materials that the robot does not have, LINK_colour.
    """
    known = set(robot.material)
    colours: dict[str, Material] = {}
    for link in robot.links:
        if link.collision and not link.visual:
            name = f"{link.name}_colour"
            while name in known:
                name += "_"
            known.add(name)
            colours[link.name] = Material(name, own_colours(robot)[link.name])
    return colours


def with_visuals(robot: Robot) -> Robot:
    """Return a robot whose links are all seen: a link without a visual as its collision shapes, in one colour.

    The colours are materials of the robot, which stand after its own (``colours_of``). Names and elements of XML of a
    collision shape are not those of the visual.
    """
    colours = colours_of(robot)
    links = (_seen(link, colours[link.name].name) if link.name in colours else link for link in robot.links)
    return replace(robot, links=tuple(links), materials=(*robot.materials, *colours.values())) if colours else robot


def _seen(link: Link, colour: str) -> Link:
    shapes = [replace(shape, name="", material=colour, stand_in="", urdf_elements=()) for shape in link.collision]
    return replace(link, visual=tuple(shapes))


def shows_collision(link: Link) -> bool:
    """Say whether the visuals of a link are what ``with_visuals`` gives it: its collision shapes, in such a colour."""
    seen, solid = ([(shape.geometry, shape.pose) for shape in shapes] for shapes in (link.visual, link.collision))
    made = all((shape.material or "").rstrip("_").endswith("_colour") for shape in link.visual)
    return bool(seen) and made and seen == solid
