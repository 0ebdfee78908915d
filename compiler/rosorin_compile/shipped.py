"""What the program brings itself: the modules of records of its own packages, in the order in which they are asked.

Packages of others say theirs by entry points (``plugins``).
"""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # for ``rosorin_compile.model``, whose public names they are
    from rosorin_compile_ros.sections.controllers.value import Controller as Controller
    from rosorin_compile_ros.sections.moveit.value import DisabledCollision as DisabledCollision

SHIPPED = (
    "rosorin_compile.commands.records",
    "rosorin_compile_import.records",
    "rosorin_compile_import.extract.records",
    "rosorin_compile_ros.records",
    "rosorin_compile_verify.records",
    "rosorin_compile_mujoco.records",
    "rosorin_compile_view.records",
    "rosorin_compile_fleet.sweep.records",
)

# The formats that packages beside the core bring; the name of one is that of its module. Those of the core are found.
FORMATS = (
    "rosorin_compile_mujoco.mjcf",
    "rosorin_compile_mujoco.scene",
    "rosorin_compile_ros.controllers",
    "rosorin_compile_ros.nav2",
    "rosorin_compile_ros.robot_localization",
    "rosorin_compile_ros.srdf",
    "rosorin_compile_sdf.sdf",
    "rosorin_compile_view.frames_picture",
    "rosorin_compile_view.page",
)

# The sections of the language that stand in folders of their own: where the record of each is.
SECTIONS = (
    "rosorin_compile.sections.servos:SERVOS",
    "rosorin_compile.sections.drive:DRIVE",
    "rosorin_compile_ros.sections.control:CONTROL",
    "rosorin_compile_ros.sections.controllers:CONTROLLERS",
    "rosorin_compile_ros.sections.moveit:MOVEIT",
    "rosorin_compile.sections.disabled_contacts:DISABLED_CONTACTS",
    "rosorin_compile_mujoco.sections.simulation:ACTUATORS",
    "rosorin_compile_mujoco.sections.simulation:TENDONS",
    "rosorin_compile_mujoco.sections.simulation:CONSTRAINTS",
    "rosorin_compile_mujoco.sections.simulation:MJCF_SENSORS",
    "rosorin_compile_mujoco.sections.simulation:CONTACT_LAYERS",
    "rosorin_compile_mujoco.sections.simulation:CONTACT_PAIRS",
    "rosorin_compile.sections.mjcf_elements:MJCF_ELEMENTS",
)

# Values of those sections that ``rosorin_compile.model`` has, and those that it had in 0.2.
VALUES = {
    "Controller": "rosorin_compile_ros.sections.controllers.value",
    "DisabledCollision": "rosorin_compile_ros.sections.moveit.value",
}
VALUES_BEFORE = dict.fromkeys(
    ("ContactPair", "Entry", "NO_SIMULATION", "Simulation", "Stop", "Tendon"),
    "rosorin_compile_mujoco.sections.simulation.value",
)


def folders() -> dict[str, Path]:
    """Return the folders of the packages that are the program, by name; they stand beside each other."""
    home = Path(__file__).parents[1]
    packages = dict.fromkeys(one.partition(".")[0] for one in (*SHIPPED, *FORMATS, *SECTIONS))
    return {name: home / name for name in packages}
