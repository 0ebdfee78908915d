"""Assign colours to links, and visuals to links with collision shapes only: the same in pages, pictures and files."""

import zlib
from collections.abc import Mapping, Sequence
from colorsys import hls_to_rgb, rgb_to_hls
from dataclasses import replace
from typing import Any

from rosorin_compile.source.cache import of_robot

from .link import Link
from .robot import Robot
from .shape import Material, Rgba

# Degrees to the next hue to try: by the golden ratio, so that no two hues are close.
_GOLDEN_ANGLE = 137.50776
_NEAR = 25.0  # the smallest difference in degrees between the hues of a link and its parent
_LIGHTNESSES, _SATURATIONS = (0.60, 0.52), (0.42, 0.10)
_ROUNDED = 0.01  # the largest change of lightness and saturation by rounding to three digits


@of_robot
def own_colours(robot: Robot) -> Mapping[str, Rgba]:
    """Return a muted colour for each link, derived from its name and different from the colour of its parent."""
    hues: dict[str, float] = {}
    colours: dict[str, Rgba] = {}
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        # a hash that is the same on every machine, and very different for similar names
        number = (zlib.crc32(link.name.encode("utf-8", "surrogatepass")) * 2_654_435_761 >> 8) & 0xFFFFFF
        hue = number % 3600 / 10
        while above is not None and abs((hue - hues[above.parent] + 180) % 360 - 180) < _NEAR:
            hue = (hue + _GOLDEN_ANGLE) % 360
        hues[link.name] = hue
        light, saturation = _LIGHTNESSES[number // 3600 % 2], _SATURATIONS["base" in link.name]
        red, green, blue = hls_to_rgb(round(hue, 1) / 360, light, saturation)
        colours[link.name] = (round(red, 3), round(green, 3), round(blue, 3), 1.0)
    return colours


def is_own(rgba: Sequence[float]) -> bool:
    """Return True if ``own_colours`` can produce a colour."""
    if len(rgba) != 4 or rgba[3] != 1.0 or not all(0 <= part <= 1 for part in rgba):
        return False
    pairs = zip(rgb_to_hls(*rgba[:3])[1:], (_LIGHTNESSES, _SATURATIONS), strict=True)
    return all(min(abs(value - one) for one in usual) < _ROUNDED for value, usual in pairs)


def colours_of(robot: Robot) -> dict[str, Material]:
    """Return a material LINK_colour for each link with collision shapes and no visual, by the name of the link."""
    names = set(robot.material)
    colours: dict[str, Material] = {}
    for link in robot.links:
        if link.collision and not link.visual:
            name = f"{link.name}_colour"
            while name in names:
                name += "_"
            names.add(name)
            colours[link.name] = Material(name, own_colours(robot)[link.name])
    return colours


def with_visuals(robot: Robot) -> Robot:
    """Return a robot in which links without a visual get their collision shapes as visuals, in one colour."""
    colours = colours_of(robot)
    links = {link.name: link for link in robot.links}
    for name, colour in colours.items():
        look: Any = {"name": "", "material": colour.name, "stand_in": "", "urdf_elements": ()}
        links[name] = replace(links[name], visual=tuple(replace(shape, **look) for shape in links[name].collision))
    materials = (*robot.materials, *colours.values())
    return replace(robot, links=tuple(links.values()), materials=materials) if colours else robot


def shows_collision(link: Link) -> bool:
    """Return True if ``with_visuals`` made the visuals of a link."""
    visual, collision = ([(shape.geometry, shape.pose) for shape in some] for some in (link.visual, link.collision))
    made = all((shape.material or "").rstrip("_").endswith("_colour") for shape in link.visual)
    return bool(visual) and made and visual == collision
