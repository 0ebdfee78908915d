"""What backends take of the model of a robot beside the public names of ``rosorin_compile.model``."""

from __future__ import annotations

from ..model.bounds import Bounds
from ..model.footprint import CORNERS, Footprint, footprint, outside, padded, solids
from ..model.frame_tree import NO_TOPIC, NOBODY, Line, Row, lines, publishers, rows, way
from ..model.geometry import IDENTITY, Rows, dot, norm, pose_of, rotation_about, rotation_of_rpy, unit
from ..model.joint import MOVING_TYPES, NODE, UNPUBLISHED, Dynamics
from ..model.kinematics import NoWay
from ..model.link import NO_SOURCE, Source
from ..model.looks import colours_of, with_visuals
from ..model.mass import principal_moments
from ..model.motion import motion, plane_axes
from ..model.robot import JointPose, of_robot
from ..model.seen import numbers, placed, seen_by
from ..model.shape import MERGED, ROWS, Material, Rgba
from ..model.simulated import (
    BODY_ELEMENT,
    CLASSIC,
    SENSOR_ELEMENT,
    TEMPLATE_ELEMENT,
    Attribute,
    GazeboSensor,
    Replicas,
    Simulated,
)
from ..model.simulation import (
    AT_ORIGIN,
    GENERAL,
    MOTOR,
    SHARED_LAYER,
    VELOCITY,
    Actuator,
    Contact,
    Marked,
    Rename,
    Renames,
    Root,
    Values,
)
from ..model.standing import HOME, home_of, reach, stands_at
from ..model.touching import NEAR, Solid, Touching, around
from ..model.tucked import left_out

__all__ = [
    "AT_ORIGIN",
    "BODY_ELEMENT",
    "CLASSIC",
    "CORNERS",
    "GENERAL",
    "HOME",
    "IDENTITY",
    "MERGED",
    "MOTOR",
    "MOVING_TYPES",
    "NEAR",
    "NOBODY",
    "NODE",
    "NO_SOURCE",
    "NO_TOPIC",
    "ROWS",
    "SENSOR_ELEMENT",
    "SHARED_LAYER",
    "TEMPLATE_ELEMENT",
    "UNPUBLISHED",
    "VELOCITY",
    "Actuator",
    "Attribute",
    "Bounds",
    "Contact",
    "Dynamics",
    "Footprint",
    "GazeboSensor",
    "JointPose",
    "Line",
    "Marked",
    "Material",
    "NoWay",
    "Rename",
    "Renames",
    "Replicas",
    "Rgba",
    "Root",
    "Row",
    "Rows",
    "Simulated",
    "Solid",
    "Source",
    "Touching",
    "Values",
    "around",
    "colours_of",
    "dot",
    "footprint",
    "home_of",
    "left_out",
    "lines",
    "motion",
    "norm",
    "numbers",
    "of_robot",
    "outside",
    "padded",
    "placed",
    "plane_axes",
    "pose_of",
    "principal_moments",
    "publishers",
    "reach",
    "rotation_about",
    "rotation_of_rpy",
    "rows",
    "seen_by",
    "solids",
    "stands_at",
    "unit",
    "way",
    "with_visuals",
]
