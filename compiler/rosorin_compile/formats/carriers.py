"""The robot of an output in which only some links are frames: what the other links add to these."""

from __future__ import annotations

from collections.abc import Mapping, Set

from rosorin_compile.model import Inertial, Joint, Robot, Shape, Transform
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.mass import together
from rosorin_compile.model.shape import ROWS


@of_robot
def carriers(robot: Robot, carried: frozenset[str]) -> Mapping[str, tuple[str, Transform]]:
    """Return for each link the carried link that it belongs to, and its pose in that.

    A link belongs to the next carried link above it, or to the topmost one if there is none. Joints between are at
    zero, and mimic joints follow their leaders.
    """

    def at_zero(joint: Joint) -> Transform:
        return joint.transform(robot.position(joint, {}) if joint.moves else 0.0)

    top = next(link.name for link in robot.walk() if link.name in carried)
    found, here = {top: (top, Transform())}, Transform()
    for joint in reversed(robot.chain(top)):
        here = here.then(at_zero(joint).inverse())
        found[joint.parent] = (top, here)
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        if link.name in carried:
            found[link.name] = (link.name, Transform())
        elif link.name not in found and above is not None:
            carrier, transform = found[above.parent]
            found[link.name] = (carrier, transform.then(at_zero(above)))
    return found


def shapes_at(robot: Robot, link: str, carried: Set[str], purpose: str, form: str = ROWS) -> list[Shape]:
    """Return the solids of a link, with those of links that are fixed to it and not carried.

    ``purpose`` is visual or collision, ``form`` that of the boxes of height maps. The shapes of other links come
    first: those mounted on the link, then those of the links that it is mounted on.
    """
    moved: list[Shape] = []
    visited, waiting, own = {link}, [(link, Transform())], list[Shape]()
    while waiting:
        name, transform = waiting.pop()
        solids = [solid for shape in getattr(robot.link[name], purpose) for solid in shape.solids(form)]
        if name == link:
            own = solids
        for solid in () if name == link else solids:
            key = ("moved", id(solid), transform)  # several formats and their proofs use it
            found: tuple[Shape, Shape] | None = robot.worked_out.get(key)
            if found is None or found[1] is not solid:  # as in a copy that was pickled
                found = robot.worked_out[key] = (solid.moved(transform), solid)
            moved.append(found[0])
        neighbours = robot.fixed_neighbours(name)
        steps = [(n, transform.then(t)) for n, t in neighbours if n not in carried and n not in visited]
        visited.update(n for n, _ in steps)
        waiting += reversed(steps)
    return [*moved, *own]


def inertials_at(robot: Robot, carried: Set[str]) -> Mapping[str, Inertial]:
    """Return the inertials of the links that are ``carried``, with those of the links that belong to each.

    Raises ValueError where a sum overflows.
    """
    parts: dict[str, list[tuple[Inertial, Transform]]] = {}
    for name, (carrier, transform) in carriers(robot, frozenset(carried)).items():
        inertial = robot.link[name].inertial
        if inertial is not None:
            parts.setdefault(carrier, []).append((inertial, transform))
    own = {name: robot.link[name].inertial for name in parts}
    return {name: one if (one := own[name]) and len(some) == 1 else together(some) for name, some in parts.items()}
