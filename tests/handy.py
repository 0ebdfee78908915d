"""A small robot with parts in loops in parts, a table, a mirror and other nodes: what there is to explain."""

from __future__ import annotations

from pathlib import Path

CALIBRATION = """\
arm:
  left: {length: 120 mm, offset: [1 mm, 2 mm]}
  right: {length: 121 mm, offset: [3 mm, 4 mm]}
"""
PARTS = """\
parts:
  finger:
    params: {length: {type: length, default: "${2 * base_length}"}, extra: 0}
    let: {tip: "${length + extra}"}
    links: {finger: {inertial: {mass: 20 g, inertia: {ixx: 1e-6, iyy: 1e-6, izz: 1e-6}}}, tip: {}}
    joints:
      joint:
        type: revolute
        parent: mount
        child: finger
        xyz: [0, "${length / 2}", 5 mm]
        axis: [0, 0, 1]
        limit: ${finger_limit}
      tip_joint: {type: fixed, parent: finger, child: tip, xyz: ["${tip}", 0, 0]}
  hand:
    params: {length: {type: length}}
    links: {palm: {}}
    joints:
      wrist: {type: fixed, parent: mount, child: palm, xyz: ["${length}", 0, 0]}
    use:
      "f${i}":
        for: {i: "${range(2)}"}
        part: finger
        parent: palm
        xyz: [0, "${(i - 0.5) * 30 * mm}", 0]
        with: {extra: "${i * mm}"}
      thumb: {part: finger, parent: mount, xyz: [1 mm, 2 mm, 3 mm], mirror: y}
"""
ROBOT = """\
robot: handy
include: [parts.yaml]
args: {scale: {type: number, default: 1}}
let:
  base_length: 10 mm
  cal: ${load("calibration.yaml").arm}
  sides: {left: 1, right: -1}
  finger_limit: {lower: 0, upper: "${upper}", effort: 1, velocity: 1}
  upper: ${45*deg * 2}
links: {base_link: {}, shelf: {collision: [{box: {size: [1 m, "${scale}", 1]}}]}}
joints:
  shelf_joint: {type: fixed, parent: base_link, child: shelf, xyz: "${[0.1, cal.left.length, scale]}"}
use:
  "${side}":
    for: {side: "${sides}"}
    part: hand
    with: {length: "${cal[side].length * scale}"}
    parent: base_link
    xyz: [0.1, "${sides[side] * cal[side].offset[1]}", 0]
sensors:
  eye: {type: camera, parent: shelf, frame: eye_link, xyz: [0, 0, 1 cm]}
publishers: {ekf: {about: fuses}, slam: {}, amcl: {}, driver: {}}
modes: {mapping: }
edges:
  - {parent: odom, child: base_link, publisher: ekf}
  - {parent: map, child: odom, publisher: slam, when: mapping}
  - {parent: map, child: odom, publisher: amcl, when: not mapping}
  - {parent: eye_link, child: chip, publisher: driver, moving: false, xyz: [0, 1 mm, 0]}
  - {parent: chip, child: inner, publisher: driver, moving: false}
poses: {open: {positions: {left_f0_joint: 45 deg}}}
outputs: {urdf: {file: handy.urdf}}
"""


def write(folder: Path) -> Path:
    """Write the description into a project; return its first file."""
    home = folder / "descriptions" / "handy"
    home.mkdir(parents=True)
    for name, text in (("robot", ROBOT), ("parts", PARTS), ("calibration", CALIBRATION)):
        (home / f"{name}.yaml").write_text(text, "utf-8")
    return home / "robot.yaml"
