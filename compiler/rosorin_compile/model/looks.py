"""Looks: a colour for each link, and visuals for links that have collision shapes alone.

The colours are those of the page (``viewer/src/colours.js``), so that a robot looks the same wherever it is shown.
"""

from __future__ import annotations

from colorsys import hls_to_rgb

from ..startup.records import replace
from .link import Link
from .robot import Robot
from .shape import Material, Rgba

# Degrees between the hues of two links: 360 times the golden ratio, so that no two come close.
_GOLDEN_ANGLE = 137.50776
_FIRST_HUE = 212.0
_DIGITS = 3


def colour_of_link(index: int) -> Rgba:
    """Return a colour for the link of that number: calm, and told apart from its neighbours; the first is grey."""
    hue = round((_FIRST_HUE + index * _GOLDEN_ANGLE) % 360, 1) / 360
    lightness, saturation = (0.52 if index % 2 else 0.60), (0.42 if index else 0.10)
    red, green, blue = hls_to_rgb(hue, lightness, saturation)
    return (round(red, _DIGITS), round(green, _DIGITS), round(blue, _DIGITS), 1.0)


def colours_of(robot: Robot) -> dict[str, Material]:
    """Return a colour for each link that has collision shapes and no visual, by its name.

    They are materials that the robot does not have, LINK_colour.
    """
    known = set(robot.material)
    colours: dict[str, Material] = {}
    for index, link in enumerate(robot.links):
        if link.collision and not link.visual:
            name = f"{link.name}_colour"
            while name in known:
                name += "_"
            known.add(name)
            colours[link.name] = Material(name, colour_of_link(index))
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
