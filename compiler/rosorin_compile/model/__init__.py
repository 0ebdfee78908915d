"""The model of a robot: frozen values in SI units. Of the rooms it knows ``diagnostics`` alone, for "did you mean".

To be read in this order: ``geometry`` (poses), ``shape`` and ``link``, ``joint`` and ``motion``, ``robot`` (all of it,
and what one asks a robot), ``kinematics`` (where frames sit in each other). Then single topics: ``mass``, ``bounds``,
``touching``, ``simulated`` (sensors), ``simulation`` (what else only simulations have), ``frame_tree``.
"""

from typing import TYPE_CHECKING

from ..shipped import VALUES, VALUES_BEFORE
from ..startup.lazily import lazily
from .geometry import Pose, Transform, Vector
from .joint import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Limit,
    Publisher,
)
from .link import Inertial, Link
from .robot import Edge, Output, Robot, Sensor
from .shape import Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere

if TYPE_CHECKING:
    from ..sections.drive.driving import Twist
    from ..sections.drive.value import Drive
    from ..shipped import Controller, DisabledCollision

__all__ = [
    "ROBOT_STATE_PUBLISHER",
    "STATIC_TRANSFORM_PUBLISHER",
    "Box",
    "Capsule",
    "Controller",
    "Cylinder",
    "DisabledCollision",
    "Drive",
    "Edge",
    "Ellipsoid",
    "Geometry",
    "HeightMap",
    "Inertial",
    "Joint",
    "Limit",
    "Link",
    "Mesh",
    "Output",
    "Pose",
    "Publisher",
    "Robot",
    "Sensor",
    "Shape",
    "Sphere",
    "Transform",
    "Twist",
    "Vector",
]

# What was public in 0.2, and still is found here, but belongs to the core alone.
_BEFORE = {
    "ServoGroup": "sections.servos.value",
    "Mimic": "model.joint",
    "Material": "model.shape",
    "JointPose": "model.robot",
    "Dynamics": "model.joint",
    "AT_JOINT": "model.simulated",
    "AXLELESS": "model.joint",
    "Actuator": "model.simulation",
    "Attribute": "model.simulated",
    "BODY_ELEMENT": "model.simulated",
    "Calibration": "model.joint",
    "Contact": "model.simulation",
    "GROUNDED": "model.shape",
    "GazeboSensor": "model.simulated",
    "IDENTITY": "model.geometry",
    "MERGED": "model.shape",
    "MOVING_TYPES": "model.joint",
    "Marked": "model.simulation",
    "NODE": "model.joint",
    "ROWS": "model.shape",
    "Replicas": "model.simulated",
    "Root": "model.simulation",
    "SENSOR_ELEMENT": "model.simulated",
    "SEVERAL_COORDINATES": "model.joint",
    "SafetyController": "model.joint",
    "SdfElement": "model.simulated",
    "Simulated": "model.simulated",
    "Source": "model.link",
    "TEMPLATE_ELEMENT": "model.simulated",
    "UNPUBLISHED": "model.joint",
    "Values": "model.simulation",
    "inertial_of": "model.mass",
    "plain": "model.shape",
    "plane_axes": "model.motion",
    "pose_of": "model.geometry",
    "principal_moments": "model.mass",
    "volume_of": "model.mass",
}

# What few ask for.
_HOMES = {
    "Drive": "sections.drive.value",
    "Twist": "sections.drive.driving",
}

__getattr__ = lazily(__name__, {**_HOMES, **VALUES, **_BEFORE, **VALUES_BEFORE}, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
