"""What the program brings itself: the modules of records of its own packages, in the order in which they are asked.

Packages of others say theirs by entry points (``plugins``).
"""

from pathlib import Path

SHIPPED = (
    "rosorin_compile.commands.records",
    "rosorin_compile_import.records",
    "rosorin_compile_import.extract.records",
    "rosorin_compile_ros.records",
    "rosorin_compile_verify.records",
    "rosorin_compile_mujoco.records",
    "rosorin_compile_view.records",
    "rosorin_compile_fleet.sweep.records",
    "rosorin_compile_fleet.check.records",
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
    "sections.servos:SERVOS",
    "sections.drive:DRIVE",
    "sections.control:CONTROL",
    "sections.controllers:CONTROLLERS",
    "sections.moveit:MOVEIT",
    "sections.disabled_contacts:DISABLED_CONTACTS",
    "sections.simulation:ACTUATORS",
    "sections.simulation:TENDONS",
    "sections.simulation:CONSTRAINTS",
    "sections.simulation:MJCF_SENSORS",
    "sections.simulation:CONTACT_LAYERS",
    "sections.simulation:CONTACT_PAIRS",
    "sections.simulation:MJCF_ELEMENTS",
)


def folders() -> dict[str, Path]:
    """Return the folders of the packages that are the program, by name; they stand beside each other."""
    here = Path(__file__).parent
    return {name: here.parent / name for name in dict.fromkeys(one.partition(".")[0] for one in SHIPPED)}
