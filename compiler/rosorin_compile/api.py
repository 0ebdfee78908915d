"""The commands ``check``, ``write`` (``all``), ``explain`` and ``schema`` for programs: values in, values out.

``compile`` and ``read`` stand in ``pipeline``, ``diff`` in ``sides``. Nothing is printed, and what is wrong with a
robot's files is no exception: it is among the diagnostics.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.cli.given import Given
from rosorin_compile.output.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, MissingPackages, has_errors, pip_install
from rosorin_compile.source.project import Description

if TYPE_CHECKING:
    from distributed import Client

    from rosorin_compile.language.explain.explanation import Answer, Explanation
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.answers import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.output.pipeline import Compiled, Understood
    from rosorin_compile.recordings.answers import Verified
    from rosorin_compile.variants.writing import WrittenVariants

    Name = str | os.PathLike[str]


@dataclass(frozen=True)
class Checked:
    """Whether the committed artifacts of a robot are those of its description.

    ``differing`` are the files that are not as compiled (missing, changed, or no artifact any more); ``lines`` says
    how they differ, as the command line does. Both are empty where ``compiled`` has errors.
    """

    compiled: Compiled
    folder: Path
    differing: tuple[str, ...]
    lines: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def same(self) -> bool:
        """Whether the robot has no errors, no engine refuses an artifact, and each is as committed."""
        return not self.differing and not has_errors(self.diagnostics)

    def __str__(self) -> str:
        """Return what differs, in lines."""
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Written:
    """What writing the artifacts of a robot into ``folder`` did to each file there, by name.

    ``kept`` are no artifacts and were left alone, ``removed`` were none either and are gone because pruning was asked
    for. With errors among the diagnostics nothing is written.
    """

    compiled: Compiled
    folder: Path
    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class Explained:
    """Where things of a robot sit, and where each of their numbers was written; none if the robot has errors."""

    answers: tuple[Explanation | Answer, ...]
    diagnostics: tuple[Diagnostic, ...]

    @classmethod
    def of(cls, found: Understood, arguments: Mapping[str, Any], names: Sequence[str], pose: str = "") -> Explained:
        """Return the same of a description without errors that was read with these arguments. Raises KeyError."""
        from rosorin_compile.language.explain.answer import NotThere, explain

        if found.lowered is None:
            raise ValueError("a description with errors has no meaning to explain")
        try:
            answers = explain(found.expanded, found.lowered, arguments, names, pose)
        except NotThere as problem:
            raise KeyError(str(problem)) from None
        return cls(tuple(answers), tuple(found.diagnostics))

    def lines(self) -> list[str]:
        """Return what the command line prints, line by line."""
        from rosorin_compile.cli.explain_text import lines

        return [line for answer in self.answers for line in lines(answer)]

    def __str__(self) -> str:
        """Return what the command line prints."""
        return "\n".join(self.lines())


def check(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
) -> Checked:
    """Compile a description and compare with its committed artifacts, as ``rosorin-compile check`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``. ``outputs`` is the folder that has a folder a robot; by
    default that of the project.
    """
    from rosorin_compile.cli.comparing import compared

    description, given, compiled = _proven(path, arguments, packages, outputs)
    said = compiled.diagnostics
    if description is None or compiled.robot is None or has_errors(said):
        return Checked(compiled, _folder(description), (), (), tuple(said))
    held = compared(given, description, compiled)
    return Checked(compiled, description.outputs, held.differing(), tuple(held.lines()), (*said, *held.diagnostics))


def write(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
    prune: bool = False,
) -> Written:
    """Compile a description and write its artifacts, the whole set or nothing, as ``rosorin-compile all`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``, ``outputs`` as in ``check``. ``prune`` removes what is
    no artifact from the robot's folder.
    """
    from rosorin_compile.cli.all import left_alone
    from rosorin_compile.output import OutputError, write_outputs

    description, _, compiled = _proven(path, arguments, packages, outputs)
    said, folder = compiled.diagnostics, _folder(description)
    if not compiled.artifacts or has_errors(said):
        return Written(compiled, folder, (), (), (), (), tuple(said))
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    try:
        done = write_outputs(folder, {**compiled.mesh_files, **files}, prune)
    except OutputError as problem:
        return Written(compiled, folder, (), (), (), (), (*said, problem.diagnostic))
    more = (*done.put_aside(folder), *left_alone(folder, done))
    return Written(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*said, *more))


def explain(
    path: Name,
    names: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    pose: str = "",
) -> Explained:
    """Return where frames, links, joints, sensors and uses of parts sit, and where each number of theirs was written.

    ``path``, ``arguments`` and ``packages`` as in ``compile``; ``names`` and ``pose`` as ``rosorin-compile explain``
    takes them. Raises KeyError for a name that the robot does not have, with what is near.
    """
    from rosorin_compile.output.pipeline import understand

    description, given, wrong = Given.asked(path, arguments, packages)
    if description is None:
        return Explained((), tuple(wrong))
    values = given.values()
    found = understand(description.path, values, packages=given.packages)
    if found.lowered is None or found.lowered.robot is None or has_errors(found.diagnostics):
        return Explained((), tuple(found.diagnostics))
    return Explained.of(found, values, names, pose)


def schema(name: str = "authoring") -> dict[str, Any]:
    """Return a JSON Schema by a name of ``rosorin-compile schema``. Raises KeyError, with what is near."""
    import json

    from rosorin_compile.cli.schema import names, text_of
    from rosorin_compile.source.diagnostics import did_you_mean

    if name not in (known := names()):
        raise KeyError(f'there is no schema "{name}"; {did_you_mean(name, known)}')
    found: dict[str, Any] = json.loads(text_of(name))
    return found


def _proven(
    path: Name, arguments: object, packages: object, outputs: Name | None
) -> tuple[Description | None, Given, Compiled]:
    """Return what becomes of a description with its meshes, read back as a command does before it writes."""
    from rosorin_compile.output.pipeline import Compiled

    description, given, wrong = Given.asked(path, arguments, packages, outputs)
    if description is None:
        return None, given, Compiled(None, (), wrong, ())
    return description, given, given.request(description).compile()


def _folder(description: Description | None) -> Path:
    return description.outputs if description is not None else Path()


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


def verify(
    robot: Name | Request,
    source: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    trust: bool = False,
    modes: Sequence[str] | Mapping[str, bool] = (),
    without: Sequence[str] = (),
    pose: str = "",
    frames: tuple[str, str] | None = None,
    since: float | None = None,
    until: float | None = None,
    namespace: str = "",
    prefix: str = "",
    stale: float = 1.0,
) -> Verified:
    """Compare a recording of the running robot with its description.

    ``robot``, ``arguments``, ``packages`` and ``trust`` as in ``simulate``. ``source`` is a rosbag2 folder, a .mcap or
    .db3 file, a file with text of ``tf2_echo`` or ``view_frames``, or "-" for such text on standard input. ``modes``
    are the modes that were on or off, by name; by default those that fit best. ``without`` names nodes that were not
    running, ``pose`` the pose of the joints while ``tf2_echo`` ran, ``frames`` its two frames. ``since`` and ``until``
    are seconds after the start of the recording, ``stale`` is the maximum age of a transform in s. ``namespace`` is
    that of the topics, ``prefix`` that of the recorded frames. Raises RequestError for a name that the robot does not
    have, invalid times, and if numpy is not installed.

    >>> result = rosorin_compile.verify("descriptions/rosorin", "recordings/drive")  # doctest: +SKIP
    >>> result.as_described, [finding.message for finding in result.findings]  # doctest: +SKIP
    (False, ['map -> odom went 10.3 s stale, 15.3 s into the recording'])
    """
    try:
        from rosorin_compile.recordings.answers import Verified
        from rosorin_compile.recordings.verification import verify_recording
    except ModuleNotFoundError as problem:
        if problem.name != "numpy":
            raise
        needs = "rosorin-compile verify needs numpy, and rosbags for recordings"
        raise MissingPackages(f"{needs}: {pip_install('verify')}") from None
    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return Verified(str(robot), os.fsdecode(source), diagnostics=tuple(wrong))
    return verify_recording(
        request,
        os.fsdecode(source),
        modes=modes,
        without=without,
        pose=pose,
        frames=frames,
        since=since,
        until=until,
        namespace=namespace,
        prefix=prefix,
        stale=stale,
    )


def sweep(
    robot: Name | Request,
    variants: Name | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    client: Client | None = None,
    *,
    trust: bool = False,
) -> Iterator[Compiled]:
    """Yield a description compiled with the arguments of each variant; nothing is written.

    ``variants`` is a list as ``rosorin-compile sweep --over`` takes it (a CSV or YAML file, or a folder), arguments by
    name, or an iterable of pairs of a name and arguments or of mappings with ``name`` among the arguments. ``robot``,
    ``arguments``, ``packages`` and ``trust`` as in ``simulate``; the arguments of a variant override ``arguments``.
    Each ``Compiled`` has its ``variant``; the order is that of ``variants``. With ``client``, a ``distributed.Client``,
    they are compiled on its cluster, and OutputError is raised if that fails.

    Errors in a variant are among its diagnostics; errors in the list itself are those of a single ``Compiled`` without
    a variant.

    >>> heights = {"low": {"height": 0.2}, "high": {"height": 0.5}}
    >>> for compiled in rosorin_compile.sweep("descriptions/mast", heights):  # doctest: +SKIP
    ...     print(compiled.variant.name, len(compiled.artifacts))
    low 2
    high 2
    """
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.variants.library import compile_variants

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        yield Compiled(None, (), wrong, ())
    else:
        yield from compile_variants(request, variants, client)


def write_sweep(
    robot: Name | Request,
    variants: Name,
    folder: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    *,
    trust: bool = False,
    jobs: int | None = None,
    whole: str = "",
    dask: str = "",
    prune: bool = False,
    report: Callable[[Diagnostic], None] = lambda _: None,
) -> WrittenVariants:
    """Compile a description with the arguments of each variant of a list, and write each into a folder of its own.

    ``robot``, ``arguments``, ``packages`` and ``trust`` as in ``simulate``. ``variants`` is a CSV or YAML file, or a
    folder with a file for each variant; then ``whole`` may name the argument that takes each file. ``folder`` gets a
    folder for each variant, and ``sweep.json``. ``jobs`` is the number of processes, by default one per core; ``dask``
    the address of a Dask scheduler. Variants that are up to date are skipped; ``prune`` removes those that are not in
    the list any more. ``report`` receives each diagnostic as soon as it is known. Raises RequestError for invalid
    arguments.

    >>> result = rosorin_compile.write_sweep("descriptions/mast", "fleet.csv", "build")  # doctest: +SKIP
    >>> result.made, result.unchanged, result.error  # doctest: +SKIP
    (3, 0, 0)
    """
    from rosorin_compile.variants.writing import WrittenVariants, write_variants

    request, wrong = Request.of(robot, arguments, packages, trust=trust)
    if request is None:
        return WrittenVariants(str(robot), os.fsdecode(folder), diagnostics=tuple(wrong))
    over, output = Path(os.fsdecode(variants)), Path(os.fsdecode(folder))
    return write_variants(request, over, output, jobs=jobs, whole=whole, dask=dask, prune=prune, report=report)
