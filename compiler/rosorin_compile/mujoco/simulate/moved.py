"""Moved: what hangs on a joint, in words: how much it weighs, and how large it is."""

from __future__ import annotations

from rosorin_compile.model import Robot

_GRAMS = 1e-3  # kg


def first_to_go(robot: Robot, joint: str, what: str = "the first is") -> str:
    """Return the end of a sentence that names a joint, and what it moves; nothing without one."""
    return f'; {what} joint "{joint}", {moved(robot, joint)}' if joint in robot.joint else ""


def moved(robot: Robot, joint: str) -> str:
    """Return what a joint moves: moving 10 g with "finger" of 50 mm."""
    child = robot.joint[joint].child
    links = [robot.link[name] for name in robot.below(child)]
    mass = sum(link.inertial.mass for link in links if link.inertial is not None)
    sides = robot.link[child].size
    size = f" of {round(1000 * max(sides), 1):.6g} mm" if sides else ""
    return f'moving {_weight(mass)} with "{child}"{size}'


def _weight(mass: float) -> str:
    """Return a mass (kg) in the unit that a person would take."""
    if mass >= 1.0:
        return f"{mass:.6g} kg"
    return f"{mass / _GRAMS:.6g} g" if mass >= _GRAMS else f"{1e6 * mass:.6g} mg"
