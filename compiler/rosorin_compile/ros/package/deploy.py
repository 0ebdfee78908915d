"""Deploy: put the artifacts of a robot into a ROS 2 package that exists."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import Robot
from rosorin_compile.output import OutputError, PackageFolder, digest, open_package_folder
from rosorin_compile.output.ros_packages import files_below
from rosorin_compile.request import Request
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, has_errors
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.rule_registry import Heading, Rule

from . import naming
from .checking import launch_files, unreadable
from .deploy_plan import Plan, ProtectedFile, afterwards, change_lines, not_ours, plan, protected_files

RULES = (
    Rule(
        "deploy-unreadable",
        "The folder cannot be read, or holds more than 50,000 files.",
        "Name the folder of the package.",
        Heading.PACKAGES,
    ),
    Rule("deploy-changes", "A note: what was changed (in the forms for programs).", topic=Heading.PACKAGES),
)


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


def deploy(
    request: Request,
    folder: Path,
    places: Mapping[str, str],
    install: Path | None = None,
    dry_run: bool = False,
    full: bool = False,
) -> Deployed:
    """Compile a robot and put its artifacts into a folder. Raises RequestError.

    ``places`` maps outputs to paths in the folder, or to ``none``. ``full`` has differences of texts in full.
    """
    if not folder.is_dir():
        raise RequestError(f'there is no folder "{folder}"; rosorin-compile package makes a new package')
    compiled = request.compile()
    result = Deployed("", str(folder), inputs=tuple(map(str, request.inputs(compiled))))
    diagnostics = [*compiled.diagnostics]
    if compiled.robot is not None and not has_errors(diagnostics):
        try:
            with open_package_folder(folder, dry_run) as target:
                deployment = _Deployment(compiled.robot, compiled.artifacts, folder, target, diagnostics)
                result = deployment.run(result, _mapped(places, compiled.artifacts), install, dry_run, full)
        except (LoadError, OutputError) as problem:
            diagnostics.append(problem.diagnostic)
        except OSError as problem:
            diagnostics.append(unreadable(folder, problem))
    return replace(result, diagnostics=tuple(diagnostics))


def _mapped(places: Mapping[str, str], artifacts: Sequence[Artifact]) -> dict[str, str]:
    """Return the places of outputs; a folder gets the name of the file. Raises RequestError."""
    names = {artifact.output: artifact.file.rpartition("/")[2] for artifact in artifacts}
    found = {}
    for output, place in places.items():
        if output not in names:
            raise RequestError(f'the robot has no output "{output}"; it has {", ".join(names)}')
        found[output] = place + names[output] if place.endswith("/") else place
    return found


@dataclass(frozen=True)
class _Deployment:
    """Artifacts of a robot and the folder that they go into, which is locked."""

    robot: Robot
    artifacts: tuple[Artifact, ...]
    folder: Path
    target: PackageFolder
    diagnostics: list[Diagnostic]

    def run(
        self, result: Deployed, mapped: Mapping[str, str], install: Path | None, dry_run: bool, full: bool
    ) -> Deployed:
        """Write the artifacts. Raises LoadError, OutputError, OSError."""
        robot, folder = self.robot, self.folder
        files = files_below(folder, skip_built=True)
        places = {**naming.read(folder, robot.name), **mapped}
        planned = plan(robot, self.artifacts, folder, files, places)
        self.diagnostics.extend(planned.diagnostics)
        if has_errors(planned.diagnostics):
            return result
        for copy in planned.copies:
            self.target.check_name(copy.place)
        data = {copy.place: copy.artifact.text.encode() for copy in planned.copies}
        there = protected_files(folder, data, self._digests(planned))
        found = list(not_ours(planned, there))
        self.diagnostics.extend(found)
        if has_errors(found):
            return result
        if not dry_run:
            self._write(data, there, places if mapped else None)
        ours = [copy.place for copy in planned.copies if FORMATS[copy.artifact.backend].located]
        self.diagnostics.extend(launch_files(robot, folder, files, ours))
        self.diagnostics.extend(afterwards(robot, planned, folder, install))
        copies = tuple(DeployedCopy(copy.place, copy.artifact.output, copy.is_same) for copy in planned.copies)
        changes = tuple(change_lines(planned.copies, full))
        return replace(result, robot=robot.name, written=not dry_run, copies=copies, changes=changes)

    def _digests(self, planned: Plan) -> dict[str, list[str]]:
        """Return the digests of files written before; one of a format without a mark is as it was written."""
        ours = {}
        for copy in planned.copies:
            robot_of = FORMATS[copy.artifact.backend].robot_of
            if copy.old is not None and robot_of is not None and robot_of(self.folder / copy.place) == self.robot.name:
                ours[copy.place] = [digest(copy.old)]
        return {**ours, **self.target.digests()}

    def _write(
        self, data: Mapping[str, bytes], there: Sequence[ProtectedFile], places: Mapping[str, str] | None
    ) -> None:
        """Write files, and the places of outputs if they are new. Raises LoadError, OutputError."""
        unlisted = {file.kept: file.data for file in there}
        if places is not None:
            unlisted[naming.FILE] = naming.text(self.folder, self.robot.name, places).encode()
        self.target.write(data, unlisted)
