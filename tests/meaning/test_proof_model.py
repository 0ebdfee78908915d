"""Whether two robots are the same, number by number: to a part of the larger one, or of one."""

from __future__ import annotations

from dataclasses import replace

from rosorin_compile.model import Joint, Link, Robot, Sensor
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.robot import JointPose
from rosorin_compile.ros.moveit import Moveit
from rosorin_compile.ros.sections.control.hardware import Block, Component
from support.comparing import different


def test_dynamics_of_zero_are_none() -> None:
    links = (Link("a"), Link("b"))
    plain, zero, damped = (
        Robot("r", links, (Joint("j", "continuous", "a", "b", dynamics=dynamics),))
        for dynamics in (None, Dynamics(), Dynamics(damping=0.1))
    )
    assert different(plain, zero, 0.0, carried_by_urdf=False) == []
    assert different(plain, damped, 0.0, carried_by_urdf=False) != []


def test_what_a_urdf_has_no_word_for_is_not_held_against_it() -> None:
    pose = JointPose("home", {"j": 1.0})
    gauge, other = (Block("b", "sensor", "some/Plugin", sensors=(Component(name),)) for name in ("gauge", "other"))
    plain = Robot("r", (Link("a"),), ())
    posed, driven, measured, otherwise = (
        replace(plain, **more)
        for more in (
            {"poses": (pose,), "modes": ("docked",), "disabled_contacts": (("a", "b"),)},
            {"moveit": Moveit(), "sensors": (Sensor("s", "imu", "a", "j"),)},
            {"control": (gauge,)},
            {"control": (other,)},
        )
    )
    for robot in (posed, driven):
        assert different(plain, robot, 0.0, carried_by_urdf=True) == []
        assert different(plain, robot, 0.0, carried_by_urdf=False) != []
    assert different(measured, otherwise, 0.0, carried_by_urdf=True) != []  # what hardware measures it has
    assert "gauge" in " ".join(different(measured, otherwise, 0.0, carried_by_urdf=True))
