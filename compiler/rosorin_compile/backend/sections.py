"""The sections of a description that backends write: their records, values, and what is worked out of them."""

from __future__ import annotations

from ..sections.control import CONTROL
from ..sections.control.value import EFFORT, JOINT_WORDS, POSITION, VELOCITY
from ..sections.controllers import CONTROLLERS
from ..sections.controllers.value import flat
from ..sections.disabled_contacts import DISABLED_CONTACTS
from ..sections.drive import DRIVE
from ..sections.drive.driving import Driving, Wheel, driving_of
from ..sections.drive.standing import stands_free
from ..sections.drive.value import ACKERMANN, DIFFERENTIAL, MECANUM, OMNI, SLIDING, TRICYCLE
from ..sections.moveit import MOVEIT
from ..sections.moveit.rules import state_path
from ..sections.moveit.value import FIXED, FLOATING, PLANAR, USER, Ball, EndEffector, Group, Moveit, Pair, VirtualJoint
from ..sections.servos import SERVOS
from ..sections.servos.value import ServoGroup
from ..sections.simulation import (
    ACTUATORS,
    CONSTRAINTS,
    CONTACT_LAYERS,
    CONTACT_PAIRS,
    MJCF_ELEMENTS,
    MJCF_SENSORS,
    TENDONS,
)
from ..sections.simulation.value import ContactPair, Entry, Tendon

__all__ = [
    "ACKERMANN",
    "ACTUATORS",
    "CONSTRAINTS",
    "CONTACT_LAYERS",
    "CONTACT_PAIRS",
    "CONTROL",
    "CONTROLLERS",
    "DIFFERENTIAL",
    "DISABLED_CONTACTS",
    "DRIVE",
    "EFFORT",
    "FIXED",
    "FLOATING",
    "JOINT_WORDS",
    "MECANUM",
    "MJCF_ELEMENTS",
    "MJCF_SENSORS",
    "MOVEIT",
    "OMNI",
    "PLANAR",
    "POSITION",
    "SERVOS",
    "SLIDING",
    "TENDONS",
    "TRICYCLE",
    "USER",
    "VELOCITY",
    "Ball",
    "ContactPair",
    "Driving",
    "EndEffector",
    "Entry",
    "Group",
    "Moveit",
    "Pair",
    "ServoGroup",
    "Tendon",
    "VirtualJoint",
    "Wheel",
    "driving_of",
    "flat",
    "stands_free",
    "state_path",
]
