"""Scenes seen off screen: this program, run by itself, lets MuJoCo draw what the camera of a scene sees.

MuJoCo is told how to draw before it is imported, so it runs in a process of its own, with EGL or OSMesa.
"""

from __future__ import annotations

import os
import subprocess
import sys
from ctypes.util import find_library
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SIZE = (480, 320)

BACK_END = next((word for word, library in (("egl", "EGL"), ("osmesa", "OSMesa")) if find_library(library)), "")


class Seen(NamedTuple):
    """What a camera sees: colours (height, width, 3), and which pixels show the robot and the floor."""

    pixels: NDArray[np.uint8]
    robot: NDArray[np.bool_]
    floor: NDArray[np.bool_]


def seen(scene: Path, folder: Path, camera: str = "overview", key: str = "home") -> Seen:
    """Return what a camera of a scene sees when the robot is at a key."""
    target = folder / "seen.npz"
    command = [sys.executable, __file__, str(scene), str(target), camera, key]
    environment = {**os.environ, "MUJOCO_GL": BACK_END}
    ran = subprocess.run(command, env=environment, capture_output=True, text=True, check=False, cwd=folder)
    assert ran.returncode == 0, ran.stderr
    with np.load(target) as made:
        return Seen(made["pixels"], made["robot"], made["floor"])


def _draw(scene: str, target: str, camera: str, key: str) -> None:
    import mujoco

    model = mujoco.MjModel.from_xml_path(scene)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, SIZE[1], SIZE[0]) as renderer:
        renderer.update_scene(data, camera=camera)
        pixels = renderer.render()
        renderer.enable_segmentation_rendering()
        renderer.update_scene(data, camera=camera)
        shown = renderer.render()
    geoms = np.where(shown[:, :, 1] == mujoco.mjtObj.mjOBJ_GEOM, shown[:, :, 0], -1)
    floor = geoms == model.geom("floor").id
    np.savez(target, pixels=pixels, robot=(geoms >= 0) & ~floor, floor=floor)


if __name__ == "__main__":
    _draw(*sys.argv[1:])
