"""The pictures of the documentation are those of the robots, as nearly as any machine draws them; scenes by MuJoCo.

``python tests/renew.py pictures`` draws them anew.
"""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.viewer.picture.draw import png
from support.drawings import pixels
from support.paths import DOCS, ROOT, ROSORIN
from support.robots import of_this_project
from support.scenes import BACK_END, seen

FOLDER = DOCS / "pictures"
EXAMPLES = ROOT / "examples"
SIZE = ("--size", "800x500")
PICTURES = {
    "rosorin.png": (str(ROSORIN), "--pose", "tuck"),
    "turtlebot3_burger.png": (str(EXAMPLES / "turtlebot3_burger" / "robot.yaml"),),
    "unitree_a1.png": (str(EXAMPLES / "unitree_a1" / "robot.yaml"), "--pose", "home"),
    "ur5e.png": (str(EXAMPLES / "ur5e" / "robot.yaml"), "--pose", "home"),
    "porter.png": (str(EXAMPLES / "porter" / "robot.yaml"), "--pose", "ready"),
    "porter_dark.png": (str(EXAMPLES / "porter" / "robot.yaml"), "--pose", "ready", "--theme", "dark"),
    "rosorin_frames.png": (str(ROSORIN), "--pose", "tuck", "--frames"),
}
SCENES = {f"scene_{path.parent.name}.png": path for path in (ROSORIN, *EXAMPLES.glob("*/robot.yaml"))}
LARGEST = 200_000  # bytes


def draw(name: str, target: Path) -> None:
    if name in SCENES:
        target.write_bytes(scene(SCENES[name]))
        return
    assert main(["picture", *PICTURES[name], *SIZE, "-o", str(target), "--force"]) == 0


def scene(description: Path) -> bytes:
    with TemporaryDirectory() as folder:
        for artifact in of_this_project(description).artifacts:
            Path(folder, artifact.file).write_text(artifact.text, "utf-8")
        return png(seen(Path(folder, "scene.xml"), Path(folder)).pixels)


@pytest.mark.slow
@pytest.mark.skipif(not BACK_END, reason="MuJoCo draws off screen with libEGL or libOSMesa")
@pytest.mark.landing("engines", "scene_ackermann_car.png")
@pytest.mark.parametrize("name", SCENES)
def test_a_committed_scene_is_that_of_the_robot(name, tmp_path):
    """Loosely: each way to draw, and each version of it, has pixels of its own."""
    draw(name, tmp_path / name)
    shown, committed = (pixels((folder / name).read_bytes()).astype(int) for folder in (tmp_path, FOLDER))
    assert shown.shape == committed.shape
    off = np.abs(shown - committed).max(axis=2)
    assert (off > 48).mean() < 0.02
    assert (FOLDER / name).stat().st_size < LARGEST


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_a_committed_picture_shows_the_robot(name, tmp_path):
    draw(name, tmp_path / name)
    shown, committed = (pixels((folder / name).read_bytes()).astype(int) for folder in (tmp_path, FOLDER))
    assert shown.shape == committed.shape
    off = np.abs(shown - committed).max(axis=2)
    assert (off > 24).mean() < 0.002  # another numpy may move an edge, and no more
    assert off.mean() < 0.5
    assert (FOLDER / name).stat().st_size < LARGEST


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for each in sys.argv[1:] or [*PICTURES, *SCENES]:
        draw(each, FOLDER / each)
