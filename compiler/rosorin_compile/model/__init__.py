"""The model of a robot: frozen dataclasses with values in SI units."""

from .drive import Drive, Twist
from .geometry import Pose, Transform, Vector
from .joint import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Joint, Limit, Publisher
from .link import DisabledCollision, Inertial, Link
from .robot import Controller, Edge, Output, Robot, Sensor
from .shape import Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere

__all__ = ["ROBOT_STATE_PUBLISHER", "STATIC_TRANSFORM_PUBLISHER", "Box", "Capsule", "Controller", "Cylinder"]
__all__ += ["DisabledCollision", "Drive", "Edge", "Ellipsoid", "Geometry", "HeightMap", "Inertial", "Joint", "Limit"]
__all__ += ["Link", "Mesh", "Output", "Pose", "Publisher", "Robot", "Sensor", "Shape", "Sphere", "Transform", "Twist"]
__all__ += ["Vector"]
