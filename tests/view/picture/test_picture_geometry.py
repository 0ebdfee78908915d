"""The pixels of pictures, compared with rays through the exact shapes."""

import random
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.model import Box as BoxShape
from rosorin_compile.model import Robot, Shape, Transform
from rosorin_compile.viewer.page.data import robot_data
from rosorin_compile.viewer.picture.draw import VIEWS
from rosorin_compile.viewer.picture.render import Camera, Scene, render
from support.drawings import HUES, first_hit, hue_name, rgba
from support.robots import compiled, compiled_text

SIZE = (320, 200)


def robot_of(folder: Path, links: dict[str, str], joints: dict[str, str] | None = None) -> Robot:
    """Return a robot whose links have the shapes that are given as text; the first one is the root."""
    first = next(iter(links))
    given = joints or {name: f"{{type: fixed, parent: {first}, child: {name}}}" for name in links if name != first}
    lines = [f"  {name}: {{visual: [{shape}]}}" for name, shape in links.items()]
    tree = [f"  {name}_joint: {joint}" for name, joint in given.items()]
    text = "robot: made\nlinks:\n" + "\n".join(lines) + ("\njoints:\n" + "\n".join(tree) if tree else "") + "\n"
    made = compiled_text(folder, text)
    assert made.robot is not None, made.diagnostics
    return made.robot


def scene_of(
    robot: Robot, direction: tuple[float, float, float], size: tuple[int, int] = SIZE
) -> tuple[dict, Scene, Camera]:
    poses = robot.poses_in_root({})
    scene = Scene(robot, poses, {})
    return poses, scene, Camera.fit(scene.bounds, direction, *size)


def drawn(scene: Scene, camera: Camera, transparent: bool) -> np.ndarray:
    return render(scene, camera, "light", transparent)


def random_robot(folder: Path, seed: int) -> Robot:
    """Return a robot of six solids of six colours, at random places; many of them are through each other."""
    chance = random.Random(seed)  # noqa: S311

    def some(low: float, high: float) -> float:
        return round(chance.uniform(low, high), 3)

    def shape() -> str:
        kind = chance.choice(["box", "cylinder", "sphere", "capsule", "height_map"])
        if kind == "box":
            return f"box: {{size: [{some(0.1, 0.5)}, {some(0.1, 0.5)}, {some(0.1, 0.5)}]}}"
        if kind == "sphere":
            return f"sphere: {{radius: {some(0.1, 0.3)}}}"
        if kind == "height_map":
            rows = [[chance.choice([0, 0.05, 0.1, 0.2]) for _ in range(4)] for _ in range(3)]
            rows[1][1] = 0.2
            return f"height_map: {{origin: [-0.15, -0.2], cell: 0.1, step: 0.05, heights: {rows}}}"
        return f"{kind}: {{radius: {some(0.05, 0.2)}, length: {some(0.1, 0.5)}}}"

    links = {name: f"{{{shape()}, rgba: {rgba(name)}}}" for name in HUES}
    first, *others = HUES
    joints = {}
    for name in others:
        xyz, rpy = [some(-0.35, 0.35) for _ in range(3)], [some(-3, 3) for _ in range(3)]
        joints[name] = f"{{type: fixed, parent: {first}, child: {name}, xyz: {xyz}, rpy: {rpy}}}"
    return robot_of(folder, links, joints)


def clear_points(
    robot: Robot, places: dict, camera: Camera, seed: int, count: int = 250
) -> Iterator[tuple[int, int, str]]:
    """Yield pixels in which, and around which by a pixel, one and the same link is met first, and clearly so."""
    chance = random.Random(seed)  # noqa: S311
    for _ in range(count):
        x, y = chance.randrange(4, camera.width - 4), chance.randrange(4, camera.height - 4)
        hits = []
        for dx, dy in ((0, 0), (-1.5, -1.5), (1.5, -1.5), (-1.5, 1.5), (1.5, 1.5)):
            ray = camera.rays(np.array(x + 0.5 + dx), np.array(y + 0.5 + dy))
            hits.append(first_hit(robot, places, camera.eye, [float(part) for part in ray]))
        if len({link for link, _ in hits}) == 1:
            yield x, y, hits[0][0]


@pytest.mark.landing("fuzz", "0", "5")
@pytest.mark.parametrize("seed", range(8))
def test_a_pixel_has_the_colour_of_the_link_that_its_ray_meets_first(tmp_path, seed):
    robot = random_robot(tmp_path, seed)
    direction = random.Random(seed).choice([*VIEWS.values(), (-1.0, 0.4, 0.5), (0.3, 1.0, -0.4)])  # noqa: S311
    places, scene, camera = scene_of(robot, direction)
    shown = drawn(scene, camera, True)
    points = list(clear_points(robot, places, camera, seed))
    assert len({link for _, _, link in points if link}) >= 3
    for x, y, link in points:
        assert (shown[y, x, 3] == 255) == bool(link), (x, y, link)
        if link:
            assert hue_name(shown[y, x]) == link, (x, y, shown[y, x])


@pytest.mark.parametrize("view", ["top", "iso"])
def test_of_shapes_in_one_plane_the_first_is_seen(tmp_path, view):
    flat = "{{box: {{size: [{0}, {0}, 0.1]}}, rgba: {1}}}"
    robot = robot_of(tmp_path, {"red": flat.format(0.3, rgba("red")), "blue": flat.format(0.4, rgba("blue"))})
    _, scene, camera = scene_of(robot, VIEWS[view])
    shown = drawn(scene, camera, True)
    x, y, _ = camera.project(np.array([0.0, 0.0, 0.05]))
    middle = shown[int(y) - 10 : int(y) + 10, int(x) - 20 : int(x) + 20].reshape(-1, 4)
    assert {hue_name(colour) for colour in middle} == {robot.links[0].name}


def test_translucent_shapes_show_what_is_behind_them(tmp_path):
    veil = [*rgba("red")[:3], 0.5]
    links = {
        "back": f"{{box: {{size: [0.1, 0.6, 0.6]}}, rgba: {rgba('blue')}}}",
        "veil": f"{{box: {{size: [0.1, 0.3, 0.3]}}, rgba: {veil}}}",
    }
    joints = {"veil": "{type: fixed, parent: back, child: veil, xyz: [0.3, 0, 0]}"}
    robot = robot_of(tmp_path, links, joints)
    _, scene, camera = scene_of(robot, VIEWS["front"])
    shown = drawn(scene, camera, False).astype(int)
    middle, beside = shown[100, 160], shown[100, 105]
    assert hue_name(beside) == "blue"
    assert middle[0] > beside[0] + 40  # red is added
    assert middle[2] > 60  # and the blue is seen through it


# The page and the pictures show the same.


def test_colours_of_links_are_those_of_the_page():
    robot = compiled().robot
    colours = {link["name"]: link["colour"] for link in robot_data(robot)["links"]}
    box = {link.name: Shape(BoxShape((0, 0, 0), (1, 1, 1))) for link in robot.links}
    bare = replace(robot, links=tuple(replace(link, visual=(), collision=(box[link.name],)) for link in robot.links))
    scene = Scene(bare, {name: Transform() for name in box}, {})
    for link, colour in zip(bare.links, scene.looks[::12, :3], strict=True):  # a box has twelve triangles
        named = colours[link.name]
        assert [int(named[at : at + 2], 16) / 255 for at in (1, 3, 5)] == pytest.approx(colour, abs=0.003)
