"""Deploy: put the artifacts of a robot into a ROS 2 package that exists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compiled import Compiled
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output import MANIFEST, OutputError, PackageFolder, digest, open_package_folder
from rosorin_compile.output.ros_packages import (
    files_below,
    install_space,
    missing,
    package_of,
    share_folder,
    undeclared,
)
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, has_errors
from rosorin_compile.source.files import is_file, read_bytes, read_text, resolve
from rosorin_compile.source.load import LoadError

from . import options as mapping
from .checking import unreadable
from .copies import (
    Difference,
    ProtectedFile,
    copies,
    difference,
    forms,
    kept,
    named_files,
    not_placed,
    other_robot,
    placed,
    protected_files,
    settle,
)
from .launch_files import check_launch_files
from .options import NOWHERE
from .package import folder_of

# Files that make a folder a package, or are stored there by the tool: no artifact replaces them.
_OF_PACKAGES = ("package.xml", "CMakeLists.txt", "setup.py", "setup.cfg", mapping.FILE, MANIFEST)


@dataclass(frozen=True)
class DeployedCopy:
    """An artifact in a folder."""

    file: Annotated[str, "as seen from the folder"]
    output: Annotated[str, "its name under `outputs`"]
    same: Annotated[bool, "whether it was there as it is compiled before the run"]


@dataclass(frozen=True)
class Deployed:
    """The artifacts of a robot in a folder; ``robot`` is empty if an error kept it from being deployed."""

    robot: str
    folder: str
    written: Annotated[bool, "false with `--dry-run`"] = False
    copies: tuple[DeployedCopy, ...] = ()
    changes: Annotated[tuple[str, ...], "what changed, in the lines that people read"] = ()
    inputs: Annotated[tuple[str, ...], "the files that the robot was compiled from"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class Copy:
    """An artifact and its place in the folder; the bytes there now, and how they differ."""

    place: str
    artifact: Artifact
    old: bytes | None
    difference: Difference | None

    @property
    def located(self) -> bool:
        return FORMATS[self.artifact.backend].located


def deploy(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    places: Mapping[str, str] | None = None,
    install: FilePath | None = None,
    dry_run: bool = False,
    full: bool = False,
    trust: bool = False,
) -> Deployed:
    """Write the artifacts of a robot into a ROS 2 package or another folder that exists.

    The result has the copies with their paths, and the changes as text; with an error its ``robot`` is empty.

    Args:
        places: The paths of outputs in the folder, or ``"none"``; they are stored there.
        install: The install space that is checked for older copies; by default the one of the workspace.
        dry_run: Write nothing.
        full: List differences of texts in full in ``changes``.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise RequestError(f'there is no folder "{folder}"; rosorin-compile package makes a new package')
    request = Request.of(robot, arguments, packages, trust=trust)
    compiled = request.compile()
    result = Deployed("", str(folder), inputs=tuple(map(str, request.inputs(compiled))))
    diagnostics = [*compiled.diagnostics]
    if compiled.robot is not None and not has_errors(diagnostics):
        mapped, space = _mapped(places or {}, compiled.artifacts), Path(install) if install is not None else None
        try:
            with open_package_folder(folder, dry_run) as target:
                planned = _deploy(compiled, compiled.robot, folder, target, mapped, space, dry_run, diagnostics)
        except (LoadError, OutputError) as problem:
            return replace(result, diagnostics=(*diagnostics, problem.diagnostic))
        except OSError as problem:
            return replace(result, diagnostics=(*diagnostics, unreadable(folder, problem)))
        if planned is not None:
            result = replace(
                result,
                robot=compiled.robot.name,
                written=not dry_run,
                copies=tuple(
                    DeployedCopy(one.place, one.artifact.output, one.old is not None and one.difference is None)
                    for one in planned
                ),
                changes=tuple(line for one in planned for line in _changes(one, full)),
            )
    return replace(result, diagnostics=tuple(diagnostics))


def _mapped(places: Mapping[str, str], artifacts: Sequence[Artifact]) -> dict[str, str]:
    names = {artifact.output: artifact.file.rpartition("/")[2] for artifact in artifacts}
    for output in places:
        if output not in names:
            raise RequestError(f'the robot has no output "{output}"; it has {", ".join(names)}')
    return {output: place + names[output] if place.endswith("/") else place for output, place in places.items()}


def _changes(copy: Copy, full: bool) -> list[str]:
    if copy.old is None:
        return [f"{copy.place}: new"]
    return copy.difference.lines(copy.place, full) if copy.difference is not None else []


def _deploy(
    compiled: Compiled,
    robot: Robot,
    folder: Path,
    target: PackageFolder,
    mapped: Mapping[str, str],
    install: Path | None,
    dry_run: bool,
    diagnostics: list[Diagnostic],
) -> list[Copy] | None:
    files = files_below(folder, skip_built=True)
    places = {**mapping.read(folder, robot.name), **mapped}
    planned = plan(robot, compiled.artifacts, folder, files, places, diagnostics)
    for copy in planned:
        target.check_name(copy.place)
    data = {copy.place: copy.artifact.text.encode() for copy in planned}
    readers = {copy.place: FORMATS[copy.artifact.backend].robot_of for copy in planned if copy.old is not None}
    # A file of a format without a mark that names this robot is taken to be as it was written.
    ours = {place: [digest(read_bytes(folder / place))] for place, read in readers.items()
            if read is not None and read(folder / place) == robot.name}  # fmt: skip
    protected = protected_files(folder, data, {**ours, **target.digests()})
    diagnostics += _in_the_way(planned, protected)
    if has_errors(diagnostics):
        return None
    if not dry_run:
        unlisted = {file.kept: file.data for file in protected}
        if mapped:
            unlisted[mapping.FILE] = mapping.text(folder, robot.name, places).encode()
        target.write(data, unlisted)
    diagnostics += check_launch_files(robot, folder, files, [copy.place for copy in planned if copy.located])
    diagnostics += _afterwards(robot, planned, folder, install)
    return planned


def plan(
    robot: Robot,
    artifacts: Sequence[Artifact],
    folder: Path,
    files: Sequence[str],
    places: Mapping[str, str],
    diagnostics: list[Diagnostic],
) -> list[Copy]:
    """Return where each artifact goes: by ``places`` (by output), else where a copy is, else by its kind.

    Adds to the diagnostics; with an error among them nothing is returned.
    """
    chosen: dict[str, str] = {}
    for artifact in artifacts:
        help = f"say --map {artifact.output}=PLACE ({NOWHERE} for nowhere)"
        place = places.get(artifact.output)
        if place is None:
            found = copies(folder, files, robot.name, artifact, artifacts)
            place = found[0] if found else _usual_place(artifact)
            if len(found) > 1:
                message = f"the folder has several copies of {artifact.file.rpartition('/')[2]}: {', '.join(found[:5])}"
                diagnostics.append(report("deploy-ambiguous", message, None, help))
            other = other_robot(folder / place, robot.name) if place != NOWHERE else ""
            if other:
                message = f"{place} is there for the robot {other}, not for {robot.name}"
                diagnostics.append(report("deploy-other-robot", message, None, help))
        if place != NOWHERE:
            first = next((output for output, taken in chosen.items() if taken == place), None)
            chosen[artifact.output] = place
            if first is not None:
                message = f"the outputs {first} and {artifact.output} would both go to {place}"
                diagnostics.append(report("deploy-ambiguous", message, None, help))
    if has_errors(diagnostics):
        return []
    going = [one for one in artifacts if one.output in chosen]
    urdf = next((chosen[one.output] for one in going if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), "")
    moved = [placed(robot, artifact, chosen[artifact.output], urdf) for artifact in going]
    package = package_of(folder)
    if package is not None and package[0] == resolve(folder):
        moved = [_with_meshes(artifact, package[1], folder, diagnostics) for artifact in moved]
    for artifact in moved:
        beside = FORMATS[artifact.backend].beside
        needed = not_placed(artifact.file, beside(artifact.text), {one.file for one in moved}) if beside else ()
        diagnostics += named_files(artifact.file, needed, folder)
    left = [one.output for one in artifacts if one.output not in chosen and places.get(one.output) != NOWHERE]
    if left:
        message = f"no copy of {', '.join(left)} is in {folder}, and none is put there"
        diagnostics.append(report("deploy-nowhere", message))
    made = []
    for artifact in moved:
        path = folder / artifact.file
        old = read_bytes(path) if is_file(path) else None
        made.append(Copy(artifact.file, artifact, old, None if old is None else difference(robot, artifact, old)))
    return made


def _usual_place(artifact: Artifact) -> str:
    deploys = FORMATS[artifact.backend].deploys and not artifact.withheld
    return f"{folder_of(artifact)}/{artifact.file.rpartition('/')[2]}" if deploys else NOWHERE


def _with_meshes(artifact: Artifact, package: str, folder: Path, diagnostics: list[Diagnostic]) -> Artifact:
    if not FORMATS.names_meshes(artifact):
        return artifact
    settled = settle(artifact.text, package, (), folder)
    diagnostics += settled.diagnostics
    return artifact if settled.diagnostics else replace(artifact, text=settled.text)


def _in_the_way(planned: Sequence[Copy], protected: Sequence[ProtectedFile]) -> Iterator[Diagnostic]:
    foreign = [one.name for one in protected if one.reason == "foreign"]
    for copy in planned:
        help = f"move it away, or say another place with --map {copy.artifact.output}=PLACE ({NOWHERE} for nowhere)"
        if copy.place.rpartition("/")[2] in _OF_PACKAGES:
            message = f"{copy.place} is a file of the package itself: no artifact goes there"
            yield report("deploy-not-ours", message, None, help)
        elif copy.place in foreign:
            message = f"this tool did not write {copy.place}: it is not replaced"
            yield report("deploy-not-ours", message, None, help)
    yield from kept(protected)


def _afterwards(robot: Robot, planned: Sequence[Copy], folder: Path, install: Path | None) -> Iterator[Diagnostic]:
    """Yield what keeps the files from being used: not installed, not declared, or not built."""
    package = package_of(folder)
    if package is None:
        yield report("deploy-no-package", f"{folder} is in no ROS package: nothing here installs the files")
        return
    root, name = package
    inside = resolve(folder).relative_to(root).as_posix()
    names = [copy.place if inside == "." else f"{inside}/{copy.place}" for copy in planned]
    if root.parent.name == "share":
        message = f"{folder} is an install space: the next colcon build overwrites what is deployed here"
        yield report("deploy-install-space", message)
        return
    for file, build in missing(root, name, names):
        message = f"{build.decided_by} of {name} does not install {file}"
        yield report("deploy-not-installed", message, None, f"add: {build.line}")
    texts = [read_text(path, errors="replace") for path in sorted(root.glob("launch/*")) if is_file(path)]
    for needed in undeclared(root, [*texts, *(copy.artifact.text for copy in planned if copy.located)]):
        message = f"package.xml of {name} does not name {needed}, which its launch files start"
        yield report("deploy-not-depended", message, None, f"add: <exec_depend>{needed}</exec_depend>")
    share = install_space(root, name) if install is None else share_folder(install, name)
    if share is None:
        if install is not None:
            yield report("deploy-no-install", f"there is no package {name} in {install}")
        return
    urdfs = [copy.place for copy in planned if FORMATS.names_meshes(copy.artifact)]
    stale = []
    for copy, file in zip(planned, names, strict=True):
        texts_now = [form.text.encode() for form in forms(robot, copy.artifact, copy.place, urdfs, name)]
        if not is_file(share / file):
            stale.append(f"{file} (missing)")
        elif read_bytes(share / file) not in texts_now:
            stale.append(f"{file} (older)")
    if stale:
        message = f"{share} is what runs, and it is not what was deployed: {', '.join(stale)}"
        help = f"colcon build --packages-select {name}; without --symlink-install, build after every deploy"
        yield report("deploy-not-built", message, None, help)
