"""The Python API."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.output.request import Request

if TYPE_CHECKING:
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated

    Name = str | os.PathLike[str]


# simulation, recordings and variants


def simulate(
    robot: Name | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    trust: bool = False,
    base: str | None = None,
    seconds: float = 2.0,
    limits: Mapping[str, float] | None = None,
    timing: bool = True,
) -> Simulated:
    """Simulate a robot in MuJoCo: at rest, in its poses, driving, and along the ranges of its joints.

    ``robot``, ``arguments`` and ``packages`` as in ``compile``, ``trust`` as in ``read``; robots in other formats are
    accepted. ``base`` is "fixed" to the world or "free" on a floor; by default a robot with a drive is free. Each pose
    is held for ``seconds`` (0.5 to 600). ``limits`` replace those of ``rosorin-compile simulate`` by name, in m, rad,
    m/s and rad/s. A result beyond a limit is a warning among the ``diagnostics``. Without ``timing`` the result is the
    same in every run. Raises RequestError for invalid values, and if MuJoCo is not installed.

    >>> result = rosorin_compile.simulate("descriptions/rosorin", limits={"hold": 0.02})  # doctest: +SKIP
    >>> result.poses[0].pose, result.poses[0].worst  # doctest: +SKIP
    ('home', ('joint5', 0.0012))
    """
    from rosorin_compile.mujoco.simulate.simulation import Simulated, simulate_robot

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return Simulated(str(robot), diagnostics=tuple(wrong))
    return simulate_robot(request, base=base, seconds=seconds, limits=limits, timing=timing)


def check_physics(
    robot: Name | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    trust: bool = False,
) -> CheckedPhysics:
    """Find links that collide at rest or while joints move, and masses that do not fit the meshes, with MuJoCo.

    ``robot``, ``arguments``, ``packages`` and ``trust`` as in ``simulate``. Raises RequestError if MuJoCo or a library
    for meshes is not installed.

    >>> result = rosorin_compile.check_physics("descriptions/rosorin")  # doctest: +SKIP
    >>> result.fine, result.looked_at.joints  # doctest: +SKIP
    (True, 46)
    """
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.physics.checking import check_robot

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    return CheckedPhysics.of(str(robot), "", None, wrong) if request is None else check_robot(request)


def collisions(
    robot: Name | Request,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    trust: bool = False,
    output: Name | None = None,
    force: bool = False,
) -> CollisionMatrix:
    """Compute the pairs of links that MoveIt does not need to check, and write them to a file.

    ``robot``, ``arguments``, ``packages`` and ``trust`` as in ``simulate``. The file is ``output``, by default
    ``collisions.yaml`` next to the description, which includes it. A file that is up to date is only computed again
    with ``force``. Distances in the result are in m. Raises RequestError if MuJoCo or a library for meshes is not
    installed, and if ``output`` is not a regular file.

    >>> result = rosorin_compile.collisions("descriptions/arm", output="collisions.yaml")  # doctest: +SKIP
    >>> [pair.links for pair in result.pairs if pair.reason == "Never"]  # doctest: +SKIP
    [('base', 'tool')]
    """
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix, compute_matrix
    from rosorin_compile.ros.srdf.planning import planning_of

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return CollisionMatrix(str(robot), "", diagnostics=tuple(wrong))
    return compute_matrix(request, planning_of, output=None if output is None else Path(output), force=force)
