"""The model of a robot: frozen values in SI units. Of the rooms it knows ``diagnostics`` alone, for "did you mean".

To be read in this order: ``geometry`` (poses), ``shape`` and ``link``, ``joint`` and ``motion``, ``robot`` (all of it,
and what one asks a robot), ``kinematics`` (where frames sit in each other). Then single topics: ``mass``, ``pulses``,
``drive`` and ``driving``, ``simulated``, ``frame_tree``.
"""

from .drive import Drive
from .geometry import IDENTITY, Pose, Transform, Vector, pose_of
from .joint import (
    MOVING_TYPES,
    NODE,
    ROBOT_STATE_PUBLISHER,
    SEVERAL_COORDINATES,
    STATIC_TRANSFORM_PUBLISHER,
    UNPUBLISHED,
    Actuator,
    Calibration,
    Dynamics,
    Joint,
    Limit,
    Mimic,
    Publisher,
    SafetyController,
)
from .link import Inertial, Link, Source
from .mass import inertial_of, principal_moments, volume_of
from .motion import plane_axes
from .robot import Edge, JointPose, Output, Robot, Sensor, ServoGroup
from .shape import Box, Capsule, Cylinder, Geometry, HeightMap, Material, Mesh, Shape, Sphere
from .simulated import (
    AT_JOINT,
    BODY_ELEMENT,
    SENSOR_ELEMENT,
    TEMPLATE_ELEMENT,
    Attribute,
    GazeboSensor,
    Replicas,
    SdfElement,
    Simulated,
)

__all__ = [
    "AT_JOINT",
    "BODY_ELEMENT",
    "IDENTITY",
    "MOVING_TYPES",
    "NODE",
    "ROBOT_STATE_PUBLISHER",
    "SENSOR_ELEMENT",
    "SEVERAL_COORDINATES",
    "STATIC_TRANSFORM_PUBLISHER",
    "TEMPLATE_ELEMENT",
    "UNPUBLISHED",
    "Actuator",
    "Attribute",
    "Box",
    "Calibration",
    "Capsule",
    "Cylinder",
    "Drive",
    "Dynamics",
    "Edge",
    "GazeboSensor",
    "Geometry",
    "HeightMap",
    "Inertial",
    "Joint",
    "JointPose",
    "Limit",
    "Link",
    "Material",
    "Mesh",
    "Mimic",
    "Output",
    "Pose",
    "Publisher",
    "Replicas",
    "Robot",
    "SafetyController",
    "SdfElement",
    "Sensor",
    "ServoGroup",
    "Shape",
    "Simulated",
    "Source",
    "Sphere",
    "Transform",
    "Vector",
    "inertial_of",
    "plane_axes",
    "pose_of",
    "principal_moments",
    "volume_of",
]
