"""Write the compiled files of a robot into an existing ROS 2 package, and check files that were deployed before."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output.atomic_files import OutputError, digest
from rosorin_compile.output.package_folder import MANIFEST, open_package_folder, read_manifest
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, has_errors
from rosorin_compile.source.files import is_file, read_bytes, read_text, resolve
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.packages import package_of

from ..launch_files import check_launch_files
from .copies import copies, diff_lines, difference, forms, missing_files, other_robot, place_meshes, protect, relocate
from .launch import LAUNCH, PUBLISHER, STATICS, carry
from .options import NOWHERE, STAMP, Options, stored_options
from .package import folder_of, make
from .package_files import files_below, undeclared_packages, uninstalled_files

_NOT_AS_WRITTEN = "not as rosorin-compile package writes it"


@dataclass(frozen=True)
class DeployedCopy:
    """A copy of an artifact in a folder, such as a URDF in a ROS package."""

    file: Annotated[str, "as seen from the folder"]
    output: Annotated[str, "its name under `outputs`"]
    same: Annotated[bool, "whether it was there as it is compiled before the run"]


@dataclass(frozen=True)
class Deployment:
    """The result of ``deploy``; ``robot`` is "" if an error prevented the deployment."""

    robot: str
    folder: str
    written: Annotated[bool, "false with `--dry-run`"] = False
    copies: tuple[DeployedCopy, ...] = ()
    changes: Annotated[tuple[str, ...], "what changed, in the lines that people read"] = ()
    inputs: Annotated[tuple[str, ...], "the files that the robot was compiled from"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def deploy(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    places: Mapping[str, str] | None = None,
    dry_run: bool = False,
    full: bool = False,
    trust: bool = False,
) -> Deployment:
    """Write the compiled outputs of a robot into an existing ROS 2 package or another existing folder.

    If an error is found, nothing is written, and ``robot`` of the result is "".

    Args:
        places: The paths in the folder by output name, or ``"none"`` for outputs that are not written.
        dry_run: Report the changes without writing files.
        full: Do not shorten the text diffs in ``changes`` of the result.
    """
    request, folder = Request.from_arguments(robot, arguments, packages, trust=trust), Path(folder)
    if not folder.is_dir():
        raise RequestError(f'there is no folder "{folder}"; rosorin-compile package makes a new package')
    if is_file(stored := folder / ".rosorin-compile-deploy.yaml"):  # written by versions before 0.4
        raise RequestError(f"{stored} is not read any more: pass its places with --map, and remove it")
    compiled = request.compile()
    made, diagnostics = compiled.robot, [*compiled.diagnostics]
    result = Deployment("", str(folder), inputs=tuple(map(str, request.inputs(compiled))))
    if made is None or has_errors(diagnostics):
        return replace(result, diagnostics=tuple(diagnostics))
    names = {artifact.output: _last(artifact) for artifact in compiled.artifacts}
    if unknown := [output for output in places or () if output not in names]:
        raise RequestError(f'the robot has no output "{unknown[0]}"; it has {", ".join(names)}')
    chosen = dict(places or {})
    chosen |= {output: place + names[output] for output, place in chosen.items() if place.endswith("/")}
    try:
        with open_package_folder(folder, dry_run) as target:
            files = files_below(folder, skip_built=True)
            planned, found = _plan(made, compiled.artifacts, folder, files, chosen)
            diagnostics += found
            texts = {one.file: one.text.encode() for one in planned}
            old = {name: read_bytes(folder / name) for name in texts if is_file(folder / name)}
            for one in planned:
                target.check_name(one.file)
                if one.file.rpartition("/")[2] in ("package.xml", "CMakeLists.txt", "setup.py", "setup.cfg", MANIFEST):
                    message = f"{one.file} is a file of the package itself: no artifact goes there"
                    diagnostics.append(report("deploy-not-ours", message, None, f"say --map {one.output}=PLACE"))
            kept, found = ({}, []) if has_errors(diagnostics) else protect(folder, texts, target.digests())
            diagnostics += found
            if not has_errors(diagnostics):
                if not dry_run:
                    target.write(texts, kept)
                located = [one.file for one in planned if FORMATS[one.backend].located]
                diagnostics += check_launch_files(made, folder, files, located)
                diagnostics += _check_use(planned, folder)
                listed, changes = [], list[str]()
                for one in planned:
                    differs = difference(made, one, old[one.file]) if one.file in old else None
                    listed.append(DeployedCopy(one.file, one.output, one.file in old and differs is None))
                    changes += diff_lines(one.file, differs, full) if differs else []
                    changes += [] if one.file in old else [f"{one.file}: new"]
                result = replace(result, robot=made.name, written=not dry_run, copies=tuple(listed))
                result = replace(result, changes=tuple(changes))
    except (LoadError, OutputError) as problem:
        diagnostics.append(problem.diagnostic)
    except OSError as problem:
        diagnostics.append(report("deploy-unreadable", f"cannot read {folder}: {problem.strerror or problem}"))
    return replace(result, diagnostics=tuple(diagnostics))


def _plan(
    robot: Robot, artifacts: Sequence[Artifact], folder: Path, files: Sequence[str], places: Mapping[str, str]
) -> tuple[list[Artifact], list[Diagnostic]]:
    """Adapt each artifact to its path (from ``places``, an existing copy or its format); return [] on errors."""
    chosen, diagnostics = dict[str, str](), list[Diagnostic]()
    for artifact in artifacts:
        format, help = FORMATS[artifact.backend], f"say --map {artifact.output}=PLACE ({NOWHERE} for nowhere)"
        place, problem = places.get(artifact.output, ""), ""
        if not place:
            found = copies(folder, files, robot.name, artifact, artifacts)
            usual = f"{folder_of(artifact)}/{_last(artifact)}" if format.deploys and not artifact.withheld else NOWHERE
            place = (found or [usual])[0]
            if len(found) > 1:
                problem = f"the folder has several copies of {_last(artifact)}: {', '.join(found[:5])}"
            elif place != NOWHERE and (other := other_robot(folder / place, robot.name)):
                message = f"{place} is there for the robot {other}, not for {robot.name}"
                diagnostics.append(report("deploy-other-robot", message, None, help))
        if place == NOWHERE:
            continue
        first = next((output for output, taken in chosen.items() if taken == place), None)
        chosen[artifact.output] = place
        if first is not None:
            problem = f"the outputs {first} and {artifact.output} would both go to {place}"
        diagnostics += [report("deploy-ambiguous", problem, None, help)] if problem else []
    if has_errors(diagnostics):
        return [], diagnostics
    going = [one for one in artifacts if one.output in chosen]
    urdf = next((chosen[one.output] for one in going if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), "")
    planned, package = [], package_of(folder)
    for artifact in going:
        moved = relocate(robot, artifact, chosen[artifact.output], urdf)
        if package is not None and package[0] == resolve(folder) and FORMATS.names_meshes(moved):
            meshes = place_meshes(moved.text, package[1], (), folder)
            diagnostics += meshes.diagnostics
            moved = moved if meshes.diagnostics else replace(moved, text=meshes.text)
        planned.append(moved)
    for artifact in planned:
        if beside := FORMATS[artifact.backend].beside:
            diagnostics += missing_files(artifact.file, beside(artifact.text), {one.file for one in planned}, folder)
    if left := [one.output for one in artifacts if one.output not in chosen and places.get(one.output) != NOWHERE]:
        message = f"no copy of {', '.join(left)} is in {folder}, and none is put there"
        diagnostics.append(report("deploy-nowhere", message))
    return planned, diagnostics


def _check_use(planned: Sequence[Artifact], folder: Path) -> Iterator[Diagnostic]:
    """Report deployed files that the package does not install, and dependencies missing in package.xml."""
    root, name = package_of(folder) or (None, "")
    if root is None:
        yield report("deploy-no-package", f"{folder} is in no ROS package: nothing here installs the files")
        return
    if root.parent.name == "share":
        message = f"{folder} is an install space: the next colcon build overwrites what is deployed here"
        yield report("deploy-install-space", message)
        return
    names = [(resolve(folder) / one.file).relative_to(root).as_posix() for one in planned]
    for file, build in uninstalled_files(root, name, names):
        message = f"{build.decided_by} of {name} does not install {file}"
        yield report("deploy-not-installed", message, None, f"add: {build.line}")
    launches = [read_text(path, errors="replace") for path in sorted(root.glob("launch/*")) if is_file(path)]
    launches += [one.text for one in planned if FORMATS[one.backend].located]
    for needed in undeclared_packages(root, launches):
        message = f"package.xml of {name} does not name {needed}, which its launch files start"
        yield report("deploy-not-depended", message, None, f"add: <exec_depend>{needed}</exec_depend>")


def _last(artifact: Artifact) -> str:
    return artifact.file.rpartition("/")[2]


@dataclass(frozen=True)
class CheckedCopies:
    """The result of ``check_deployed``; ``robot`` is "" if an error prevented the comparison."""

    robot: str = ""
    same: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()
    lines: Annotated[tuple[str, ...], "what differs, in the lines that people read"] = ()
    inputs: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def check_deployed(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    full: bool = False,
    trust: bool = False,
) -> CheckedCopies:
    """Compare the compiled outputs of a robot with their copies in a package, an install space or another folder.

    Args:
        full: Do not shorten the text diffs in ``lines`` of the result.
    """
    request, folder = Request.from_arguments(robot, arguments, packages, trust=trust), Path(folder)
    compiled = request.compile()
    result, diagnostics = CheckedCopies(), [*compiled.diagnostics]
    if compiled.robot is not None and not has_errors(diagnostics):
        try:
            result = _compare(compiled, compiled.robot, request, folder, full, diagnostics)
        except LoadError as problem:
            diagnostics.append(problem.diagnostic)
        except OSError as problem:
            diagnostics.append(report("deploy-unreadable", f"cannot read {folder}: {problem.strerror or problem}"))
    return replace(result, inputs=tuple(map(str, request.inputs(compiled))), diagnostics=tuple(diagnostics))


def _compare(
    compiled: CompileResult, robot: Robot, request: Request, folder: Path, full: bool, diagnostics: list[Diagnostic]
) -> CheckedCopies:
    artifacts, files = compiled.artifacts, files_below(folder, skip_built=False)
    by_place: dict[str, list[Artifact]] = {}
    absent = []
    for artifact in artifacts:
        found = copies(folder, files, robot.name, artifact, artifacts)
        for place in found:
            by_place.setdefault(place, []).append(artifact)
        absent += [] if found else [artifact]
    urdfs = [place for place, those in by_place.items() if any(FORMATS.names_meshes(one) for one in those)]
    same, lines, differing = list[str](), list[str](), list[str]()
    for place, those in sorted(by_place.items()):
        package = (package_of((folder / place).parent) or (folder, ""))[1]
        right = [form for one in those for form in forms(robot, one, place, urdfs, package)]
        old = read_bytes(folder / place)
        if any(old == form.text.encode() for form in right):
            same.append(place)
        elif differs := difference(robot, right[0], old):
            differing.append(place)
            lines += diff_lines(place, differs, full)
    for place, data in _written_by_package(compiled, robot, request, folder, files).items():
        if place in files and read_bytes(folder / place) == data:
            same.append(place)
        else:
            differing.append(place)
            lines.append(f"{place}: {_NOT_AS_WRITTEN if place in files else 'it is not there'}")
    diagnostics += unfinished_runs(folder, files)
    needed = [one for one in absent if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)]
    diagnostics += [report("deployed-missing", f"there is no {_last(one)} in {folder}") for one in needed]
    if others := ", ".join(_last(one) for one in absent if one not in needed):
        diagnostics.append(report("deployed-missing", f"there is no copy of {others} in {folder}", severity=NOTE))
    diagnostics += check_launch_files(robot, folder, files, [place for place in by_place if place.endswith(".py")])
    return CheckedCopies(robot.name, tuple(same), tuple(differing), tuple(lines))


def _written_by_package(
    compiled: CompileResult, robot: Robot, request: Request, folder: Path, files: Sequence[str]
) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    made: dict[Path, dict[str, bytes]] = {}
    for name in files:
        above, _, last = name.rpartition("launch/")
        is_launch = last.startswith(f"{LAUNCH}.") or last in (PUBLISHER, STATICS)
        root, package = (package_of((folder / name).parent) if is_launch else None) or (None, "")
        if root is None or STAMP.encode() not in read_bytes(folder / name, 1000):
            continue
        if root not in made:
            options = stored_options(root, Options(package))
            carried, _ = carry(compiled, request, options)
            made[root] = make(robot, compiled.artifacts, options, (), root, None, carried)[0]
            found |= {f"{above}{place}": data for place, data in carried.files.items()} if carried else {}
        if f"launch/{last}" in made[root]:
            found[name] = made[root][f"launch/{last}"]
    return found


def unfinished_runs(folder: Path, files: Sequence[str]) -> Iterator[Diagnostic]:
    """Report packages whose manifest shows that an interrupted run wrote only some of the files."""
    for name in (name for name in files if name.rpartition("/")[2] == MANIFEST):
        package = (folder / name).parent
        states: dict[str, list[str]] = {"new": [], "old": [], "changed since": []}
        for file, digests in read_manifest(package).items():
            if not isinstance(digests, str):
                current = digest((package / file).read_bytes()) if (package / file).is_file() else None
                is_old = current == (digests[0] if len(digests) > 1 else None)
                states["new" if current == digests[-1] else "old" if is_old else "changed since"].append(file)
        groups = [f"{', '.join(group)}: {state}" for state, group in states.items() if group]
        if len(groups) > 1:
            message = f"{package} has files of two runs, because the last one was ended while it wrote: "
            yield report("deployed-mixed", message + "; ".join(groups))
