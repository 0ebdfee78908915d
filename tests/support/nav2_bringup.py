"""A stand-in for nav2_bringup: a launch file with the nodes and remaps of the real one, and a parameter file."""

from pathlib import Path

import yaml

from support.paths import data_text

STAND_IN = yaml.safe_load(data_text("nav2_bringup.yaml"))
NODES = {
    one: {name: list(map(tuple, remaps)) for name, remaps in nodes.items()} for one, nodes in STAND_IN["nodes"].items()
}
NODES["kilted"] = NODES["jazzy"]
TAKES = {
    kind: ({True: stamped, False: plain}, odometry) for kind, (stamped, plain, odometry) in STAND_IN["takes"].items()
}
ON_TF = ("diff_drive", "omni_wheel_drive", "tricycle")  # the others have their transforms on ~/tf_odometry
SENDERS = ("controller_server", "behavior_server", "docking_server")


def write_nav2_bringup(folder: Path, distribution: str) -> Path:
    """Write the share folder of nav2_bringup of a distribution, and return it."""
    bringup = folder / "nav2_bringup"
    files = {
        "launch/bringup_launch.py": STAND_IN["launch"].format(nodes=NODES[distribution]),
        "params/nav2_params.yaml": STAND_IN["tuned"],
    }
    for file, text in files.items():
        (bringup / file).parent.mkdir(parents=True, exist_ok=True)
        (bringup / file).write_text(text, "utf-8")
    return bringup
