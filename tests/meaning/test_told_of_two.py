"""What two robots differ in, of things that a description alone has, or few robots have; and what is no difference."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rosorin_compile.compare.diff import compare_robots
from rosorin_compile.compare.difference import YAML, Difference, Side
from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Box, HeightMap, Inertial, Joint, Link, Pose, Robot, Shape
from rosorin_compile.model.robot import Sensor
from rosorin_compile.model.simulation import BODY_ELEMENT, SensorElement

URDF, MJCF, DRIVER = FORMATS["urdf"], FORMATS["mjcf"], FORMATS["robot_model"]
BALL = Inertial(1.0, Pose(), 0.1, 0.1, 0.1)
BOX = Shape(Box((-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)), name="case")
MAP = HeightMap((0.0, 0.0), 0.1, ((0.1, 0.2), (0.3, 0.4)), 0.1)
STAIRS = replace(MAP, bottom=((0.0, 0.1), (0.2, 0.3)))
ROBOT = Robot(
    "r",
    (Link("base", BALL, collision=(BOX,)), Link("arm", BALL), Link("hand", BALL)),
    (Joint("hip", "continuous", "base", "arm"), Joint("wrist", "fixed", "arm", "hand")),
)


def having(robot: Robot, name: str, **values: object) -> Robot:
    """Return a robot of which one link has other values."""
    links = (replace(link, **values) if link.name == name else link for link in robot.links)  # type: ignore[arg-type]
    return replace(robot, links=tuple(links))


def compared(a: Robot, b: Robot, tolerance: float = 1e-9, formats: tuple[object, object] = (YAML, YAML)) -> Difference:
    return compare_robots(Side("a", formats[0], a), Side("b", formats[1], b), tolerance)  # type: ignore[arg-type]


def shaped(*shapes: Shape) -> Robot:
    return having(ROBOT, "base", collision=shapes)


@pytest.mark.parametrize(
    "robot",
    [
        ROBOT,
        shaped(Shape(STAIRS)),
        having(ROBOT, "arm", inertial=Inertial(0.0, Pose(), 0.0, 0.0, 1e-3)),
        having(ROBOT, "arm", inertial=Inertial(1.0, Pose(), 0.0, 0.0, 0.0)),
    ],
)
def test_a_robot_is_the_same_as_itself_without_any_tolerance(robot: Robot) -> None:
    assert not compared(robot, robot, 0.0).items


def test_a_height_map_and_boxes_cannot_be_compared_where_a_link_has_one_box() -> None:
    found = compared(shaped(Shape(MAP)), ROBOT, formats=(YAML, DRIVER))
    assert "the collision of base: a height map on one side, boxes on the other" in found.not_compared
    assert not [item for item in found.items if item.kind == "shape"]


def test_values_for_simulation_are_named_where_a_file_has_no_word_for_them() -> None:
    lit = having(ROBOT, "base", mjcf_elements=("<light/>", "<camera/>"), mjcf={"mocap": True})
    told = "values for simulation and publishers: b is a URDF, which has no word for it"
    assert told in compared(lit, ROBOT, formats=(YAML, URDF)).not_compared


def test_a_site_of_a_sensor_is_no_frame_that_a_description_lacks() -> None:
    site = SensorElement(BODY_ELEMENT, "site", "spot", "hand")
    described = replace(ROBOT, sensors=(Sensor("imu", "imu", "hand", "wrist", simulated=(site,)),))
    spot = Joint("at_spot", "fixed", "hand", "spot")
    simulated = replace(ROBOT, links=(*ROBOT.links, Link("spot")), joints=(*ROBOT.joints, spot))
    found = compared(described, simulated, formats=(YAML, MJCF))
    assert not found.items
    told = "spot of b: a simulation has sites and cameras of its own for the sensors of a description"
    assert told in found.not_compared
    assert [item.name for item in compared(ROBOT, simulated, formats=(YAML, MJCF)).items] == ["spot"]
