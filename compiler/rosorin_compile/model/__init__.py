"""The model of a robot: frozen values in SI units. Of the rooms it knows ``diagnostics`` alone, for "did you mean".

To be read in this order: ``geometry`` (poses), ``shape`` and ``link``, ``joint`` and ``motion``, ``robot`` (all of it,
and what one asks a robot), ``kinematics`` (where frames sit in each other). Then single topics: ``mass``, ``bounds``,
``touching``, ``simulated`` (sensors), ``simulation`` (what else only simulations have), ``frame_tree``.
"""

from typing import TYPE_CHECKING

from rosorin_compile.source.lazily import lazily

from .geometry import Pose, Transform, Vector
from .joint import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Limit, Publisher
from .link import Inertial, Link
from .robot import Edge, Output, Robot, Sensor
from .shape import Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere

if TYPE_CHECKING:
    from .controllers import Controller
    from .drive import Drive
    from .driving import Twist
    from .moveit import DisabledCollision

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
    "ContactPair": "model.simulator",
    "Entry": "model.simulator",
    "NO_SIMULATION": "model.simulator",
    "Simulation": "model.simulator",
    "Stop": "model.simulator",
    "Tendon": "model.simulator",
    "ServoGroup": "model.servos",
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
    "Controller": "model.controllers",
    "DisabledCollision": "model.moveit",
    "Drive": "model.drive",
    "Twist": "model.driving",
}

__getattr__ = lazily(__name__, {**_HOMES, **_BEFORE}, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
