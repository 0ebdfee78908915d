"""Checking what is deployed: every copy of an artifact below a folder, and the launch files there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output import MANIFEST, digest, read_manifest
from rosorin_compile.output.committed import Comparison
from rosorin_compile.output.ros_packages import files_below, package_of
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, has_errors
from rosorin_compile.source.files import read_bytes
from rosorin_compile.source.load import LoadError

from . import options as mapping
from .carrying import Carried, described
from .copies import Difference, copies, difference, forms
from .launch_files import check_launch_files
from .options import NOWHERE, STAMP, Options, stored_options
from .package import make
from .starting import LAUNCH, PUBLISHER, STATICS

if TYPE_CHECKING:
    from rosorin_compile.compare.changes import Change

_NOT_AS_WRITTEN = "not as rosorin-compile package writes it"


@dataclass(frozen=True)
class CheckedCopies:
    """The copies of artifacts in a folder; ``robot`` is empty if an error kept them from being compared."""

    robot: str = ""
    same: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()
    lines: Annotated[tuple[str, ...], "what differs, in the lines that people read"] = ()
    unlike: tuple[tuple[str, Difference | None], ...] = field(default=(), repr=False)
    inputs: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)

    def compared(self) -> tuple[Comparison, list[tuple[str, str]]]:
        """Return how copies differ, and those that are other files; a change that several copies show is one."""
        changes: dict[tuple[str, ...], Change] = {}
        found = [(place, one) for place, one in self.unlike if one is not None]
        for place, one in found:
            for change in one.changes:
                known = changes.get(change[:4], change._replace(artifacts=()))
                changes[change[:4]] = known._replace(artifacts=(*known.artifacts, place))
        texts = tuple(text._replace(file=place) for place, one in found for text in one.texts)
        others = [(place, _NOT_AS_WRITTEN) for place, one in self.unlike if one is None]
        return Comparison(tuple(changes.values()), texts, same=False), others


def unreadable(folder: Path, problem: OSError) -> Diagnostic:
    """Return the error about a folder that cannot be read."""
    return report("deploy-unreadable", f"cannot read {folder}: {problem.strerror or problem}")


def check_deployed(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    full: bool = False,
    trust: bool = False,
) -> CheckedCopies:
    """Compare the artifacts of a robot with the copies in a package, an install space or another folder.

    Args:
        full: List differences of texts in full in ``lines``.
    """
    request = Request.of(robot, arguments, packages, trust=trust)
    folder = Path(folder)
    compiled = request.compile()
    result = CheckedCopies(inputs=tuple(map(str, request.inputs(compiled))))
    diagnostics = [*compiled.diagnostics]

    def carry(options: Options) -> Carried | None:
        return described(compiled, request, options)[0]

    if compiled.robot is not None and not has_errors(diagnostics):
        try:
            files = files_below(folder, skip_built=False)
            places = mapping.read(folder, compiled.robot.name)
            found = _check(compiled.robot, compiled.artifacts, folder, files, places, full, carry)
            result = replace(found, inputs=result.inputs)
            diagnostics += found.diagnostics
        except LoadError as problem:
            diagnostics.append(problem.diagnostic)
        except OSError as problem:
            diagnostics.append(unreadable(folder, problem))
    return replace(result, diagnostics=tuple(diagnostics))


def _check(
    robot: Robot,
    artifacts: Sequence[Artifact],
    folder: Path,
    files: Sequence[str],
    places: Mapping[str, str],
    full: bool,
    carry: Callable[[Options], Carried | None],
) -> CheckedCopies:
    by_place: dict[str, list[Artifact]] = {}
    for artifact in artifacts:
        place = places.get(artifact.output, "")
        for one in [place] if place in files else copies(folder, files, robot.name, artifact, artifacts):
            by_place.setdefault(one, []).append(artifact)
    urdfs = [place for place, those in by_place.items() if any(FORMATS.names_meshes(one) for one in those)]
    same: list[str] = []
    lines: list[str] = []
    unlike: list[tuple[str, Difference | None]] = []
    for place, those in sorted(by_place.items()):
        package = package_of((folder / place).parent)
        right = [form for one in those for form in forms(robot, one, place, urdfs, package[1] if package else "")]
        old = read_bytes(folder / place)
        if any(old == form.text.encode() for form in right):
            same.append(place)
        else:
            found = difference(robot, right[0], old)
            unlike.append((place, found))
            lines += found.lines(place, full) if found else []
    for place, data, what in _generated(robot, artifacts, folder, files, carry):
        there = read_bytes(folder / place) if place in files else None
        if there == data:
            same.append(place)
        else:
            unlike.append((place, None))
            lines.append(f"{place}: it is not there" if there is None else f"{place}: {what}")
    diagnostics = [*unfinished_runs(folder, files), *_missing(artifacts, by_place, folder, places)]
    diagnostics += check_launch_files(robot, folder, files, [place for place in by_place if place.endswith(".py")])
    differing = tuple(place for place, _ in unlike)
    return CheckedCopies(
        robot.name, tuple(same), differing, tuple(lines), tuple(unlike), diagnostics=tuple(diagnostics)
    )


def _generated(
    robot: Robot,
    artifacts: Sequence[Artifact],
    folder: Path,
    files: Sequence[str],
    carry: Callable[[Options], Carried | None],
) -> Iterator[tuple[str, bytes, str]]:
    """Yield the launch files of packages of ours, with what they have to contain, and the descriptions they compile."""
    made: dict[Path, dict[str, bytes]] = {}
    for name in files:
        above, _, last = name.rpartition("launch/")
        is_launch = last.startswith(f"{LAUNCH}.") or last in (PUBLISHER, STATICS)
        package = package_of((folder / name).parent) if is_launch else None
        if package is None or STAMP.encode() not in read_bytes(folder / name, 1000):
            continue
        if package[0] not in made:
            options = stored_options(package[0], Options(package[1]), ())
            carried = carry(options)
            whole = made[package[0]] = make(robot, artifacts, options, (), package[0], None, carried).files
            for place in carried.files if carried and whole else ():
                yield f"{above}{place}", whole[place], "not the description that is compiled"
        data = made[package[0]].get(f"launch/{last}")
        if data is not None:
            yield name, data, _NOT_AS_WRITTEN


def unfinished_runs(folder: Path, files: Sequence[str]) -> Iterator[Diagnostic]:
    """Yield an error for each manifest of an unfinished run that has written some of its files, and not all."""
    for name in (name for name in files if name.rpartition("/")[2] == MANIFEST):
        package = (folder / name).parent
        states: dict[str, list[str]] = {"new": [], "old": [], "changed since": []}
        for file, digests in read_manifest(package).items():
            if not isinstance(digests, str):
                current = digest((package / file).read_bytes()) if (package / file).is_file() else None
                is_old = current == digests[0] if len(digests) > 1 else current is None
                states["new" if current == digests[-1] else "old" if is_old else "changed since"].append(file)
        groups = [f"{', '.join(group)}: {state}" for state, group in states.items() if group]
        if len(groups) > 1:
            message = f"{package} has files of two runs, because the last one was ended while it wrote: "
            yield report("deployed-mixed", message + "; ".join(groups))


def _missing(
    artifacts: Sequence[Artifact], by_place: Mapping[str, Sequence[Artifact]], folder: Path, places: Mapping[str, str]
) -> Iterator[Diagnostic]:
    there = {artifact.output for those in by_place.values() for artifact in those}
    others = []
    for artifact in artifacts:
        place = places.get(artifact.output)
        name = place or artifact.file.rpartition("/")[2]
        if artifact.output in there or place == NOWHERE:
            continue
        if place or FORMATS.feeds(artifact, ROBOT_STATE_PUBLISHER):
            yield report("deployed-missing", f"there is no {name} in {folder}")
        else:
            others.append(name)
    if others:
        yield report("deployed-missing", f"there is no copy of {', '.join(others)} in {folder}", severity=NOTE)
