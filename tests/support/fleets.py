"""Fleets: robots of one description, each with a calibration, made by a sweep; all right but for what is planted."""

from __future__ import annotations

import json
import random
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.cli import main
from support.commands import write_files

BOT = {
    "descriptions/bot/robot.yaml": """\
robot: bot
args:
  lidar_x: {type: length, default: 48 mm}
  lidar_y: {type: length, default: 12 mm}
  lidar_yaw: {type: angle, default: 180 deg}
  lidar_z: {type: length, default: 100 mm}
  camera_pitch: {type: angle, default: 90 deg}
  wheel: {type: length, default: 32 mm}
  side: {one_of: [left, right], default: left}
  mast: {default: true}
links:
  base_link:
    collision: [{box: {size: [200 mm, 150 mm, 40 mm]}}]
  laser: {collision: [{cylinder: {radius: 20 mm, length: 30 mm}}], inertial: {of: collision, mass: 100 g}}
  camera:
    collision: [{box: {size: [20 mm, 90 mm, 25 mm]}}]
    inertial: {of: collision, mass: 50 g, source: {status: stand_in, note: the camera is not weighed}}
  wheel: {collision: [{cylinder: {radius: "${wheel}", length: 20 mm}}], inertial: {of: collision, mass: 100 g}}
  flag: {}
  pole: {if: "${mast}"}
joints:
  laser_joint:
    type: fixed
    parent: base_link
    child: laser
    xyz: ["${lidar_x}", "${lidar_y}", "${lidar_z}"]
    rpy: [0, 0, "${lidar_yaw}"]
  camera_joint: {type: fixed, parent: base_link, child: camera, xyz: [80 mm, 0, 60 mm], rpy: [0, "${camera_pitch}", 0]}
  wheel_joint: {type: continuous, parent: base_link, child: wheel, xyz: [0, 80 mm, "${wheel}"], axis: [0, 1, 0]}
  flag_joint: {type: fixed, parent: "${'laser' if side == 'left' else 'camera'}", child: flag}
  pole_joint: {if: "${mast}", type: fixed, parent: base_link, child: pole, xyz: [0, 0, 20 mm]}
outputs:
  urdf: {file: bot.urdf, number_format: six}
  mjcf: {file: bot.xml}
  sdf: {file: bot.sdf}
  frames: {file: frames.md}
  robot_model: {file: model.json, joints: [laser_joint, camera_joint], rename: {laser: lidar_frame}}
""",
}

Rows = dict[str, dict[str, Any]]


def calibrated(count: int, seed: int = 1) -> Rows:
    """Return robots r000, r001, ... that were measured: about the same numbers, no two alike."""
    random_of = random.Random(seed)  # noqa: S311 - nothing is kept secret
    spread = {"lidar_x": (0.048, 5e-4), "lidar_y": (0.012, 3e-4), "lidar_yaw": (3.141, 0.01), "wheel": (0.0325, 1e-4)}
    return {
        f"r{index:03}": {name: round(random_of.gauss(*of), 6) for name, of in spread.items()} for index in range(count)
    }


def swept(home: Path, rows: Mapping[str, Mapping[str, Any]], files: Mapping[str, str] = BOT, *words: str) -> Path:
    """Make robots in ``fleet`` of the current folder, and return their sweep.json as seen from there."""
    write_files(home, files)
    texts = {name: ", ".join(f"{key}: {value}" for key, value in row.items()) for name, row in rows.items()}
    (home / "rows.yaml").write_text("".join(f"{name}: {{{text}}}\n" for name, text in texts.items()), "utf-8")
    main(["sweep", "-q", "-j", "1", "--over", "rows.yaml", "-o", "fleet", *words])
    return Path("fleet/sweep.json")


def lines_of(file: Path) -> list[dict[str, Any]]:
    """Return the variants of a sweep.json."""
    return list(json.loads(file.read_text("utf-8"))["variants"])


def rewrite(file: Path, variants: Sequence[Mapping[str, Any]]) -> None:
    """Write variants into a sweep.json."""
    head = file.read_text("utf-8").partition("\n")[0]
    lines = ",\n".join(json.dumps(one) for one in variants)
    file.write_text(f"{head}\n{lines}\n]}}\n", "utf-8")
