"""The sections of a description that backends write: their records, values, and what is worked out of them."""

from __future__ import annotations

from ..sections.disabled_contacts import DISABLED_CONTACTS
from ..sections.drive import DRIVE
from ..sections.drive.driving import Driving, Wheel, driving_of
from ..sections.drive.standing import stands_free
from ..sections.drive.value import ACKERMANN, DIFFERENTIAL, MECANUM, OMNI, SLIDING, TRICYCLE
from ..sections.mjcf_elements import MJCF_ELEMENTS
from ..sections.servos import SERVOS
from ..sections.servos.value import ServoGroup

__all__ = [
    "ACKERMANN",
    "DIFFERENTIAL",
    "DISABLED_CONTACTS",
    "DRIVE",
    "MECANUM",
    "MJCF_ELEMENTS",
    "OMNI",
    "SERVOS",
    "SLIDING",
    "TRICYCLE",
    "Driving",
    "ServoGroup",
    "Wheel",
    "driving_of",
    "stands_free",
]
