"""The kinematics of drives: wheel speeds for a velocity of the base and back, for every kind; and the table of ROS."""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.model import Box, Capsule, Cylinder, Joint, Link, Pose, Robot, Shape, Sphere
from rosorin_compile.model.drive import Drive, Twist, drive_kinematics, rolling_radius
from support.robots import compiled_text

RADIUS = 0.04
TYRE = Shape(Cylinder(RADIUS, 0.02), Pose(rpy=(math.pi / 2, 0, 0)))


def robot(drive: Drive, places: Mapping[str, Pose], steered: Mapping[str, str] | None = None) -> Robot:
    """Return a robot with wheels at places, each on the base or on the link of the joint that steers it."""
    links, joints = [Link("base")], []
    for name, pose in places.items():
        parent = f"{(steered or {})[name]}_link" if name in (steered or {}) else "base"
        axis = (0.0, 0.0, 1.0) if name in drive.steering else (0.0, 1.0, 0.0)
        links.append(Link(f"{name}_link", collision=() if name in drive.steering else (TYRE,)))
        joints.append(Joint(name, "continuous", parent, f"{name}_link", pose, axis))
    return Robot("r", tuple(links), tuple(joints), drive=drive)


def at(x: float, y: float, yaw: float = 0.0) -> Pose:
    return Pose((x, y, RADIUS), (0.0, 0.0, yaw))


CORNERS = {"front_left": (1, 1), "rear_left": (-1, 1), "front_right": (1, -1), "rear_right": (-1, -1)}


def mecanum(wheelbase: float, track: float, x: float = 0.0, y: float = 0.0) -> Robot:
    places = {name: at(x + sx * wheelbase / 2, y + sy * track / 2) for name, (sx, sy) in CORNERS.items()}
    return robot(Drive("mecanum", {name: (name,) for name in CORNERS}), places)


# ros2_controllers, mecanum_drive_controller: 1/r * (vx, vy, k * wz) with these signs, k = (wheelbase + track) / 2.
SIGNS = {"front_left": (1, -1, -1), "rear_left": (1, 1, -1), "front_right": (1, 1, 1), "rear_right": (1, -1, 1)}

speed = st.floats(-2, 2)
size = st.floats(0.05, 1.0)


@given(size, size, speed, speed, speed, speed, speed)
def test_a_mecanum_drive_has_the_signs_of_ros2_controllers(
    wheelbase: float, track: float, x: float, y: float, vx: float, vy: float, wz: float
) -> None:
    driving = drive_kinematics(mecanum(wheelbase, track, x, y))
    assert (driving.wheelbase, driving.track) == (pytest.approx(wheelbase), pytest.approx(track))
    assert driving.centre == (pytest.approx(x), pytest.approx(y))
    k = (wheelbase + track) / 2
    speeds = driving.speeds(Twist(vx, vy, wz))
    for name, (a, b, c) in SIGNS.items():
        assert speeds[name] == pytest.approx((a * vx + b * vy + c * k * wz) / RADIUS, abs=1e-9)


def omni(count: int, radius: float, first: float) -> Robot:
    angles = {f"w{i}": first + math.tau * i / count for i in range(count)}
    places = {n: at(radius * math.cos(a), radius * math.sin(a), a - math.pi / 2) for n, a in angles.items()}
    return robot(Drive("omni", {"wheels": tuple(angles)}), places)


def differential(track: float, x: float, pairs: int = 1) -> Robot:
    places = {
        f"{side}{i}": at(x + 0.1 * i, sign * track / 2) for side, sign in (("l", 1), ("r", -1)) for i in range(pairs)
    }
    joints = {side: tuple(n for n in places if n[0] == side[0]) for side in ("left", "right")}
    return robot(Drive("differential", joints), places)


@given(
    st.one_of(st.builds(mecanum, size, size, speed, speed), st.builds(omni, st.integers(3, 6), size, speed)),
    speed,
    speed,
    speed,
)
def test_what_goes_sideways_comes_back(robot: Robot, vx: float, vy: float, wz: float) -> None:
    driving = drive_kinematics(robot)
    assert driving.slides
    assert driving.velocity(driving.speeds(Twist(vx, vy, wz))) == pytest.approx((vx, vy, wz), abs=1e-9)


@given(size, speed, st.integers(1, 3), speed, speed)
def test_two_sides_come_back(track: float, x: float, pairs: int, vx: float, wz: float) -> None:
    driving = drive_kinematics(differential(track, x, pairs))
    speeds = driving.speeds(Twist(vx, 9.0, wz))  # it has no vy
    # ros2_controllers, diff_drive_controller: (v -+ w * track / 2) / r
    assert speeds["l0"] == pytest.approx((vx - wz * track / 2) / RADIUS, abs=1e-9)
    assert speeds["r0"] == pytest.approx((vx + wz * track / 2) / RADIUS, abs=1e-9)
    assert driving.velocity(speeds) == pytest.approx((vx, 0.0, wz), abs=1e-9)


def car(wheelbase: float, track: float, front: bool) -> Robot:
    """Return a car: driven in front, where it steers, or behind."""
    places = {
        "sl": at(wheelbase, track / 2),
        "sr": at(wheelbase, -track / 2),
        "fl": Pose(),
        "fr": Pose(),
        "rl": at(0, track / 2),
        "rr": at(0, -track / 2),
    }
    joints = {"steering": ("sl", "sr"), "driven": ("fl", "fr") if front else ("rl", "rr"), "rolling": ("rl", "rr")}
    return robot(Drive("ackermann", joints), places, {"fl": "sl", "fr": "sr"})


@given(size, size, st.booleans(), st.floats(0.1, 2), st.floats(-1, 1))
def test_a_car_steers_about_one_point_and_comes_back(
    wheelbase: float, track: float, front: bool, vx: float, curve: float
) -> None:
    wz = curve * vx / (wheelbase + track)
    driving = drive_kinematics(car(wheelbase, track, front))
    assert driving.wheelbase == pytest.approx(wheelbase)
    assert driving.track == pytest.approx(track)
    angles = driving.angles(Twist(vx, 0, wz))
    if wz:  # Ackermann: the axles of all wheels meet at x = 0, y = vx / wz
        for name, y in (("sl", track / 2), ("sr", -track / 2)):
            assert math.tan(angles[name]) == pytest.approx(wheelbase / (vx / wz - y))
    speeds = driving.speeds(Twist(vx, 0, wz))
    assert driving.velocity(speeds, angles) == pytest.approx((vx, 0.0, wz), abs=1e-9)


def tricycle(wheelbase: float) -> Robot:
    drive = Drive("tricycle", {"steering": ("s",), "driven": ("f",), "rolling": ("l", "r")})
    places = {"s": at(wheelbase, 0), "f": Pose(), "l": at(0, 0.2), "r": at(0, -0.2)}
    return robot(drive, places, {"f": "s"})


@given(size, speed, speed)
def test_a_tricycle_comes_back(wheelbase: float, vx: float, wz: float) -> None:
    driving = drive_kinematics(tricycle(wheelbase))
    twist = Twist(vx, 0, wz)
    # ros2_controllers, tricycle_controller: alpha = atan(wz * wheelbase / vx), the wheel at vx / cos(alpha)
    angles, speeds = driving.angles(twist), driving.speeds(twist)
    assert abs(angles["s"]) <= math.pi / 2
    assert abs(speeds["f"]) == pytest.approx(math.hypot(vx, wz * wheelbase) / RADIUS, abs=1e-9)
    assert driving.velocity(speeds, angles) == pytest.approx(twist, abs=1e-9)


def test_a_wheel_whose_axis_is_turned_round_turns_the_other_way() -> None:
    plain = differential(0.3, 0.0)
    turned = replace(plain, joints=(replace(plain.joints[0], axis=(0.0, -1.0, 0.0)), plain.joints[1]))
    speeds = drive_kinematics(turned).speeds(Twist(0.4))
    assert speeds == {"l0": pytest.approx(-10), "r0": pytest.approx(10)}
    assert drive_kinematics(turned).velocity(speeds) == pytest.approx((0.4, 0, 0))


def test_wheels_in_one_place_say_nothing() -> None:
    with pytest.raises(ValueError, match="do not say how the base moves"):
        drive_kinematics(differential(0.0, 0.0)).velocity({"l0": 1.0, "r0": 1.0})


def test_a_robot_without_a_drive_has_none() -> None:
    with pytest.raises(ValueError, match='"r" has no drive'):
        drive_kinematics(Robot("r", (Link("base"),), ()))


@pytest.mark.parametrize(
    ("shapes", "radius"),
    [
        ((TYRE,), RADIUS),
        ((Shape(Sphere(0.03), Pose((0.0, 0.5, 0.01))),), 0.04),
        ((Shape(Capsule(0.01, 0.2), Pose((0, 0, 0.02))),), 0.13),
        ((Shape(Cylinder(0.03, 0.08)),), 0.05),  # it lies across the axle: the corner is at 30, 40 mm
        ((Shape(Box((-1, -1, -1), (1, 1, 1))), TYRE), RADIUS),
        ((Shape(Box((-1, -1, -1), (1, 1, 1))),), None),
        ((), None),
    ],
)
def test_round_shapes_say_the_radius(shapes: tuple[Shape, ...], radius: float | None) -> None:
    wheel = Robot(
        "r", (Link("base"), Link("w", collision=shapes)), (Joint("j", "continuous", "base", "w", axis=(0, 1, 0)),)
    )
    assert rolling_radius(wheel, "j") == (None if radius is None else pytest.approx(radius, abs=1e-6))
    seen = replace(wheel, links=(Link("base"), Link("w", visual=shapes)))
    assert rolling_radius(seen, "j") == rolling_radius(wheel, "j")


def test_the_wheels_of_the_library_drive_as_they_are_mounted(tmp_path: Path) -> None:
    """The rollers are links of their own, and mirrored wheels: both are as ROS has them."""
    uses = "".join(
        f"  {name}: {{part: wheels/mecanum, parent: base_link, xyz: [{0.1 * x}, {0.12 * y}, 0.05],"
        f" with: {{radius: 48 mm, width: 40 mm, mass: 200 g}}{', mirror: y' if x * y < 0 else ''}}}\n"
        for name, (x, y) in CORNERS.items()
    )
    text = f"robot: r\nlinks: {{base_link: {{}}}}\nuse:\n{uses}"
    text += f"drive: {{mecanum: {{{', '.join(f'{name}: {name}_joint' for name in CORNERS)}}}}}\n"
    text += "outputs: {urdf: {file: r.urdf}}\n"
    driving = drive_kinematics(compiled_text(tmp_path, text).robot)
    speeds = driving.speeds(Twist(0.048, 0.0, 0.0))
    assert list(speeds.values()) == pytest.approx([1, 1, 1, 1])
    speeds = driving.speeds(Twist(0.0, 0.0, 1.0))
    assert speeds["front_right_joint"] == pytest.approx(0.22 / 0.048)
