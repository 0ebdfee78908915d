"""Deploying: where the artifacts go in a package that people already have, and what that changes there.

A package that stands there already may be one of ours, which was told what it is made of.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output import MANIFEST, digest, is_generated, kept_name
from rosorin_compile.output.ros_packages import install_space, missing, package_of, share_folder, undeclared
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Source, error
from rosorin_compile.source.files import exists, is_file, read_bytes, read_text, resolve
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.xml.markup import Element, MarkupError, parse

from .copies import Difference, difference, forms, placed
from .finding import copies, other_robot
from .meshes import named_files, not_placed, settle
from .naming import FILE, NOWHERE
from .package import Options, folder_of
from .views import topics_of

RULES = (
    Rule(
        "deploy-other-robot",
        "Where an artifact would go, that of another robot stands.",
        "`--map OUTPUT=PLACE`",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-ambiguous",
        "The folder has several copies of an artifact, or two outputs would go to one place.",
        "`--map OUTPUT=PLACE`",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-not-ours",
        "Where an artifact would go, a file stands that the tool did not write, or one of the package itself.",
        "Move it away, or `--map OUTPUT=PLACE` (`none`: nowhere).",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-kept",
        "A warning: a file was changed since the tool wrote it, or it is unknown which program wrote it. It is "
        "replaced; as it was, it is kept beside the new one.",
        "Bring the change into the description, and remove what was kept.",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-nowhere",
        "A note: outputs that go nowhere, for there is no copy of them yet.",
        "`--map OUTPUT=PLACE`, or `none`",
        Heading.PACKAGES,
    ),
    Rule("deploy-no-package", "A note: the folder is in no ROS package.", topic=Heading.PACKAGES),
    Rule(
        "deploy-not-installed",
        "A warning: `setup.py` or `CMakeLists.txt` does not install a file.",
        "Add the line that is given.",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-not-depended",
        "A warning: `package.xml` does not name a package whose nodes the launch files start.",
        "Add the line that is given.",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-not-built",
        "A warning: the install space has older copies, or none.",
        "`colcon build`, after every deploy.",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-no-install",
        "The folder that `--install` names does not have the package.",
        "Name the install folder of the workspace.",
        Heading.PACKAGES,
    ),
    Rule(
        "deploy-install-space",
        "A warning: the folder is an install space, which the next build writes over.",
        "Deploy into the sources.",
        Heading.PACKAGES,
    ),
    Rule(
        "package-exists",
        "The folder has files of a package that the tool did not make.",
        "A new folder, or `rosorin-compile deploy`.",
        Heading.PACKAGES,
    ),
)


class Copy(NamedTuple):
    """An artifact and its place in the folder; the bytes there now, None if there are none, and how they differ."""

    place: str
    artifact: Artifact
    old: bytes | None
    difference: Difference | None

    @property
    def is_same(self) -> bool:
        """Whether the place holds exactly this artifact."""
        return self.old is not None and self.difference is None


class Plan(NamedTuple):
    """What deploying would write; nothing if the diagnostics hold an error."""

    copies: tuple[Copy, ...]
    diagnostics: list[Diagnostic]


def plan(
    robot: Robot, artifacts: Sequence[Artifact], folder: Path, files: Sequence[str], told: Mapping[str, str]
) -> Plan:
    """Return where each artifact goes: as ``told`` (place by output), else where a copy is, else by its kind."""
    places: dict[str, str] = {}
    diagnostics: list[Diagnostic] = []
    for artifact in artifacts:
        place = told.get(artifact.output)
        if place is None:
            there = copies(folder, files, robot.name, artifact, artifacts)
            place = _only(artifact, there, diagnostics)
            diagnostics += _others(robot, artifact, folder, place)
        if place != NOWHERE:
            places[artifact.output] = place
    diagnostics += _clashes(places)
    if any(one.severity == "error" for one in diagnostics):
        return Plan((), diagnostics)
    main = next((places[a.output] for a in artifacts if _is_main(a) and a.output in places), "")
    going = [placed(robot, a, places[a.output], main) for a in artifacts if a.output in places]
    package = package_of(folder)
    if package is not None and package[0] == resolve(folder):
        going = [_with_meshes(artifact, package[1], folder, diagnostics) for artifact in going]
    for artifact in going:
        names = FORMATS[artifact.backend].beside
        wanted = not_placed(artifact.file, names(artifact.text), {one.file for one in going}) if names else ()
        diagnostics += named_files(artifact.file, wanted, folder)
    left = [a.output for a in artifacts if a.output not in places and told.get(a.output) != NOWHERE]
    if left:
        message = f"no copy of {', '.join(left)} is in {folder}, and none is put there"
        help = f"--map OUTPUT=PLACE puts one there; --map OUTPUT={NOWHERE} keeps it quiet"
        diagnostics.append(Diagnostic("deploy-nowhere", NOTE, message, None, (), help))
    return Plan(tuple(_copy(robot, artifact, folder) for artifact in going), diagnostics)


def _is_main(artifact: Artifact) -> bool:
    """Say whether an artifact is what robot_state_publisher reads."""
    return FORMATS.feeds(artifact, ROBOT_STATE_PUBLISHER)


def _only(artifact: Artifact, places: Sequence[str], diagnostics: list[Diagnostic]) -> str:
    """Return the one place of an artifact; where there is none yet, that of its kind."""
    name = artifact.file.rpartition("/")[2]
    if not places:
        deploys = FORMATS[artifact.backend].deploys and not artifact.withheld
        return f"{folder_of(artifact)}/{name}" if deploys else NOWHERE
    if len(places) > 1:
        message = f"the folder has several copies of {name}: {', '.join(places[:5])}"
        help = f"say which with --map {artifact.output}=PLACE ({NOWHERE} for nowhere)"
        diagnostics.append(error("deploy-ambiguous", message, None, help))
    return places[0]


def _others(robot: Robot, artifact: Artifact, folder: Path, place: str) -> Iterator[Diagnostic]:
    """Yield an error where a place that nobody told holds the artifact of another robot."""
    other = other_robot(folder / place, robot.name) if place != NOWHERE else ""
    if other:
        message = f"{place} is there for the robot {other}, not for {robot.name}"
        help = f"say another place with --map {artifact.output}=PLACE, or this one to write over it"
        yield error("deploy-other-robot", message, None, help)


def _with_meshes(artifact: Artifact, package: str, folder: Path, diagnostics: list[Diagnostic]) -> Artifact:
    """Return a URDF whose meshes are in the package, if they are there; else say what is missing."""
    if not FORMATS.names_meshes(artifact):
        return artifact
    settled = settle(artifact.text, package, (), folder)
    diagnostics += settled.diagnostics
    return artifact if settled.diagnostics else dataclasses.replace(artifact, text=settled.text)


def _clashes(places: Mapping[str, str]) -> Iterator[Diagnostic]:
    taken: dict[str, str] = {}
    for output, place in places.items():
        other = taken.setdefault(place, output)
        if other != output:
            message = f"the outputs {other} and {output} would both go to {place}"
            yield error("deploy-ambiguous", message, None, f"say --map {output}=PLACE")


def _copy(robot: Robot, artifact: Artifact, folder: Path) -> Copy:
    path = folder / artifact.file
    old = read_bytes(path) if is_file(path) else None
    return Copy(artifact.file, artifact, old, None if old is None else difference(robot, artifact, old))


# What makes a folder a package, or is remembered there: no artifact goes there, whoever wrote it.
_OF_PACKAGES = ("package.xml", "CMakeLists.txt", "setup.py", "setup.cfg", FILE)


@dataclasses.dataclass(frozen=True)
class ProtectedFile:
    """A file that is not replaced without a copy: ``kept`` is the name for the copy, ``data`` the content.

    It is "foreign" if the tool did not write it, "edited" if it was changed since, "unknown" if that is not recorded.
    """

    name: str
    reason: Literal["foreign", "edited", "unknown"]
    kept: str
    data: bytes


def protected_files(
    folder: Path, files: Mapping[str, bytes], digests: Mapping[str, Sequence[str]], own_package: bool = False
) -> list[ProtectedFile]:
    """Return the files that ``files`` would replace and that have none of the ``digests`` of what was written.

    In a package of the tool's own no file is foreign: older versions wrote no manifest. Raises OSError.
    """
    protected = []
    for name, new in files.items():
        path = folder / name
        old = path.read_bytes() if path.is_file() and not path.is_symlink() else new
        if old == new or not old.strip() or digest(old) in digests.get(name, ()):
            continue
        if name not in digests and is_generated(old):
            continue
        reason: Literal["foreign", "edited", "unknown"] = "edited" if name in digests else "unknown"
        if name not in digests and is_generated(new) and not own_package:
            reason = "foreign"
        kept = Path(name).with_name(kept_name(path, old).name).as_posix()
        protected.append(ProtectedFile(name, reason, kept, old))
    return protected


def not_ours(plan: Plan, there: Sequence[ProtectedFile]) -> Iterator[Diagnostic]:
    """Yield what is in the way of a plan: files of others are not replaced, those that were changed are kept."""
    outputs = {copy.place: copy.artifact.output for copy in plan.copies}
    of_package = [place for place in outputs if place.rpartition("/")[2] in (*_OF_PACKAGES, MANIFEST)]
    for place in of_package:
        message = f"{place} is a file of the package itself: no artifact goes there"
        yield error("deploy-not-ours", message, None, f"say another place with --map {outputs[place]}=PLACE")
    for one in there:
        if one.reason == "foreign" and one.name not in of_package:
            message = f"this tool did not write {one.name}: it is not replaced"
            help = f"move it away, or say another place with --map {outputs[one.name]}=PLACE ({NOWHERE} for nowhere)"
            yield error("deploy-not-ours", message, None, help)
    yield from kept(there)


def kept(there: Iterable[ProtectedFile]) -> Iterator[Diagnostic]:
    """Yield which files are kept beside those that replace them, and why."""
    for one in there:
        if one.reason == "foreign":
            continue
        if one.reason == "edited":
            message = f"{one.name} was changed since this tool wrote it; as it was, it goes to {one.kept}"
            help = "bring the change into the description, and remove that file"
        else:
            message = f"{one.name} has no mark of this tool; as it was, it goes to {one.kept}"
            help = "remove that file if it is not needed"
        yield Diagnostic("deploy-kept", WARNING, message, None, (), help)


def change_lines(copies_: Sequence[Copy], full: bool) -> list[str]:
    """Return what changes, as lines of plain text."""
    lines: list[str] = []
    for copy in copies_:
        if copy.old is None:
            lines.append(f"{copy.place}: new")
        elif copy.difference is not None:
            lines += copy.difference.lines(copy.place, full)
    return lines


def afterwards(robot: Robot, plan: Plan, folder: Path, install: Path | None) -> Iterator[Diagnostic]:
    """Yield what keeps the written files from the robot: not installed, or an install space with older copies."""
    package = package_of(folder)
    if package is None:
        message = f"{folder} is in no ROS package: nothing here says how the files get to the robot"
        yield Diagnostic("deploy-no-package", NOTE, message, None, (), "rosorin-compile package writes a package")
        return
    root, name = package
    inside = resolve(folder).relative_to(root).as_posix()
    names = [copy.place if inside == "." else f"{inside}/{copy.place}" for copy in plan.copies]
    if root.parent.name == "share":
        message = f"{folder} is an install space: the next colcon build writes over what is deployed here"
        yield Diagnostic("deploy-install-space", WARNING, message, None, (), "deploy into the sources, and build")
        return
    for file, build in missing(root, name, names):
        message = f"{build.decided_by} of {name} does not install {file}"
        yield Diagnostic("deploy-not-installed", WARNING, message, None, (), f"add: {build.line}")
    yield from _undeclared(plan, root, name)
    share = install_space(root, name) if install is None else share_folder(install, name)
    if share is None and install is not None:
        message = f"there is no package {name} in {install}"
        yield error("deploy-no-install", message, None, "name the install folder of the workspace")
    if share is not None:
        yield from _stale(robot, plan, names, share, name)


def _undeclared(plan: Plan, root: Path, name: str) -> Iterator[Diagnostic]:
    texts = [read_text(path, errors="replace") for path in sorted(root.glob("launch/*")) if is_file(path)]
    texts += [copy.artifact.text for copy in plan.copies if FORMATS[copy.artifact.backend].located]
    for needed in undeclared(root, texts):
        message = f"package.xml of {name} does not name {needed}, which its launch files start"
        yield Diagnostic("deploy-not-depended", WARNING, message, None, (), f"add: <exec_depend>{needed}</exec_depend>")


def _stale(robot: Robot, plan: Plan, names: Sequence[str], share: Path, package: str) -> Iterator[Diagnostic]:
    """Yield which files of an install space are not those that the sources hold now."""
    stale = []
    urdfs = [copy.place for copy in plan.copies if FORMATS.names_meshes(copy.artifact)]
    for copy, name in zip(plan.copies, names, strict=True):
        path = share / name
        texts = [form.text.encode() for form in forms(robot, copy.artifact, copy.place, urdfs, package)]
        is_there = is_file(path)
        if not is_there or read_bytes(path) not in texts:
            stale.append(f"{name} ({'older' if is_there else 'missing'})")
    if stale:
        message = f"{share} is what runs, and it is not what was deployed: {', '.join(stale)}"
        help = f"colcon build --packages-select {package}; without --symlink-install, build after every deploy"
        yield Diagnostic("deploy-not-built", WARNING, message, None, (), help)


STAMP = "Generated by rosorin-compile"


def refused(target: Path, names: Iterable[str]) -> Diagnostic | None:
    """Return why a package may not be written into a folder: it would write over files of somebody else."""
    manifest = target / "package.xml"
    if is_file(manifest) and STAMP in _text(manifest):
        return None
    there = [name for name in ("package.xml", *sorted(names)) if exists(target / name)]
    if not there:
        return None
    message = f"{target} has a {there[0]} that this tool did not make"
    help = "name a new folder; rosorin-compile deploy puts the artifacts into a package that you have"
    return error("package-exists", message, None, help)


def told_before(target: Path, options: Options, sensors: Iterable[str]) -> Options:
    """Return ``options`` with what the package in ``target`` was told when it was made, if it is one of ours."""
    manifest = target / "package.xml"
    text = _text(manifest) if is_file(manifest) else ""
    if STAMP not in text:
        return options
    try:
        root = parse(Source(str(manifest), text)).root
    except MarkupError:
        return options
    elements = {child.tag: child for child in root.iter()}
    changes: dict[str, Any] = {
        field: elements[tag].text.strip()
        for field, tag in (
            ("name", "name"),
            ("version", "version"),
            ("license", "license"),
            ("url", "url"),
            ("maintainer", "maintainer"),
        )
        if tag in elements
    }
    changes |= {"build_type": elements["build_type"].text.strip()} if "build_type" in elements else {}
    changes |= _of_ours(elements)
    changes |= _email(elements)
    return dataclasses.replace(options, **changes, topics=topics_of(target, set(sensors)))


def _of_ours(elements: dict[str, Element]) -> dict[str, Any]:
    if "rosorin_compile" not in elements:
        return {}
    own = elements["rosorin_compile"]
    return {"at_launch": own.get("compile_at_launch") == "true", "starts": tuple((own.get("starts") or "").split())}


def _email(elements: dict[str, Element]) -> dict[str, str]:
    email = elements["maintainer"].get("email") if "maintainer" in elements else ""
    return {"email": email} if email else {}


def _text(path: Path) -> str:
    return read_bytes(path).decode("utf-8", "replace")
