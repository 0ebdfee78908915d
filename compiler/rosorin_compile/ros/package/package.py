"""Write a ROS 2 package with the artifacts of a robot, launch files and an RViz configuration."""

from __future__ import annotations

import math
import posixpath
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.mesh_files import SearchResult, urdf_file_name
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Robot
from rosorin_compile.output.atomic_files import OutputError, digest
from rosorin_compile.output.package_folder import open_package_folder
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, error, has_errors
from rosorin_compile.source.files import exists, is_file, read_bytes
from rosorin_compile.source.project import Description
from rosorin_compile.source.yaml_text import Scalar

from ..graph import topics_of_sensors
from ..ports import IN, full_topic, message_of_sensor, ports
from .bringup import Bringup, bringup
from .copies import companions, missing_files, place_meshes, protect
from .launch import CarriedDescription, PackageFile, carry, launch_files, launch_values
from .options import NO_LICENSE, NO_MAIL, NOBODY, STAMP, Options, file_name, options_of

if TYPE_CHECKING:
    from rosorin_compile.formats.compilation import CompileResult


_BUILT_BY = {"ament_cmake": ("CMakeLists.txt",), "ament_python": ("setup.py", "setup.cfg")}
_FOLDERS = ("config", "doc", "launch", "meshes", "rviz")  # in addition to the folders of output formats
_NODES = ("robot_state_publisher", "tf2_ros")
_LAUNCH = ("ament_index_python", "launch", "launch_ros", "launch_xml", "launch_yaml", "ros2launch")
# Folder by file extension, for output formats without a folder.
_BY_ENDING = {".rviz": "rviz", ".launch.py": "launch"}
_BY_ENDING |= dict.fromkeys((".dot", ".html", ".md", ".mmd", ".svg"), "doc")
# Files that users may edit: an edited file is not replaced.
LICENSE, CHANGELOG, TEST = "LICENSE", "CHANGELOG.rst", "test/test_urdf.py"
LICENSES = ("Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "MIT")  # SPDX identifiers of licenses with a template


@dataclass(frozen=True)
class WrittenPackage:
    """The result of the function ``package``; the field ``package`` is "" if an error prevented writing."""

    package: str
    folder: str
    files: Annotated[tuple[str, ...], "all files of it, as seen from the folder"] = ()
    written: Annotated[tuple[str, ...], "those that are new or others than before"] = ()
    inputs: Annotated[tuple[str, ...], "the files that the robot was compiled from"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def package(
    robot: FilePath | Request,
    folder: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    name: str | None = None,
    build_type: str | None = None,
    version: str | None = None,
    maintainer: str | None = None,
    license: str | None = None,  # noqa: A002 - as in package.xml
    url: str | None = None,
    compile_at_launch: bool | None = None,
    control: bool | None = None,
    moveit: bool | None = None,
    nav2: bool | None = None,
    trust: bool = False,
) -> WrittenPackage:
    """Write a ROS 2 package with the compiled outputs of a robot.

    In a package that this function wrote before, options that are None keep their values. If an error is found, nothing
    is written, and ``package`` of the result is "".

    Args:
        folder: The folder of the package.
        name: The name of the package; by default, the name of the robot followed by ``_description``.
        build_type: ``"ament_cmake"``, the default, or ``"ament_python"``.
        version: The version, three numbers; by default ``"0.1.0"``.
        maintainer: The maintainer, as ``"Name <mail@example.org>"``.
        license: The license as an SPDX identifier.
        url: The website of the package.
        compile_at_launch: Compile the description at launch, with its arguments as launch arguments.
        control: Add a launch file that starts the controller_manager and the controllers.
        moveit: Add a launch file that starts MoveIt.
        nav2: Add a launch file that starts Nav2 and robot_localization.
    """
    request, folder = Request.from_arguments(robot, arguments, packages, trust=trust), Path(folder)
    compiled = request.compile()
    result = WrittenPackage("", str(folder), inputs=tuple(map(str, request.inputs(compiled))))
    diagnostics = [*compiled.diagnostics]
    if compiled.robot is None or has_errors(diagnostics):
        return replace(result, diagnostics=tuple(diagnostics))
    try:
        with open_package_folder(folder) as target:
            given = {"name": name, "build_type": build_type, "version": version, "maintainer": maintainer}
            given |= {"license": license, "url": url}
            switches = {"at_launch": compile_at_launch, "control": control, "moveit": moveit, "nav2": nav2}
            options = options_of(folder, compiled.robot.name, given, switches)
            carried, lost = carry(compiled, request, options)
            sources = [request.description.path.parent, request.description.outputs]
            files, found = make(compiled.robot, compiled.artifacts, options, sources, folder, compiled, carried)
            diagnostics += [*lost, *found]
            manifest = folder / "package.xml"
            is_ours = is_file(manifest) and STAMP.encode() in read_bytes(manifest)
            if not is_ours and (there := [name for name in ("package.xml", *sorted(files)) if exists(folder / name)]):
                message = f"{folder} has a {there[0]} that this tool did not make"
                help = "name a new folder; rosorin-compile deploy puts the artifacts into a package that you have"
                diagnostics.append(error("package-exists", message, None, help))
            if files and not has_errors(diagnostics):
                digests, ours = target.digests(), dict(files)
                for name in (CHANGELOG, LICENSE):  # keep edited files
                    if is_file(folder / name) and digest(read_bytes(folder / name)) not in digests.get(name, ()):
                        ours.pop(name, None)
                copies, remarks = protect(folder, ours, digests, own_package=True)
                diagnostics += remarks
                new = tuple(name for name in target.write(ours, copies) if name in files)
                result = replace(result, package=options.name, files=tuple(sorted(files)), written=new)
    except OutputError as problem:
        diagnostics.append(problem.diagnostic)
    return replace(result, diagnostics=tuple(diagnostics))


def make(
    robot: Robot,
    artifacts: Sequence[Artifact],
    options: Options,
    sources: Sequence[Path],
    target: Path,
    compiled: CompileResult | None = None,
    carried: CarriedDescription | None = None,
) -> tuple[dict[str, bytes], list[Diagnostic]]:
    """Return (contents of the files of a ROS package by path, diagnostics).

    ``carried`` is the description to compile at launch, or None. Meshes that ``compiled`` did not find are looked up in
    the folders ``sources`` and in the package folder ``target``.
    """
    main = next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    published = FORMATS.published_format()
    if main is None:
        message, help = "no output is a URDF, which a package needs", f"add an output with the backend {published.name}"
        return {}, [error("package-no-urdf", message, None, help)]
    placed: dict[str, Artifact] = {}
    for artifact in artifacts:
        if FORMATS[artifact.backend].located:
            continue  # the launch files of the package replace this artifact
        last = artifact.file.rpartition("/")[2]
        last = file_name(last, published.file.format("robot")) if artifact is main else last
        place = f"{folder_of(artifact)}/{last}"
        if (first := placed.setdefault(place, artifact)) is not artifact:
            message = f"the outputs {first.output} and {artifact.output} would both be {place} in the package"
            help = "let their file names differ, not only their folders"
            return {}, [error("package-same-place", message, None, help)]
    urdf = next(place for place, artifact in placed.items() if artifact is main)
    started, missing = bringup(robot, placed, options.starts)
    remarks = [missing] if missing else list(started.check())
    if has_errors(remarks):
        return {}, remarks
    files: dict[str, bytes] = {}
    needs, diagnostics = set(started.packages()), list[Diagnostic]()
    searched = (compiled.meshes if compiled is not None else None) or SearchResult()
    known = {**searched.by_name, **{urdf_file_name(name): file for name, file in searched.by_name.items()}}
    for place, artifact in placed.items():
        beside = FORMATS[artifact.backend].beside
        if FORMATS.names_meshes(artifact):
            meshes = place_meshes(artifact.text, options.name, sources, target, known, searched.missing, place)
            artifact = replace(artifact, text=meshes.text)
            needs.update(meshes.packages)
            diagnostics += meshes.diagnostics
            files.update({name: read_bytes(path) for name, path in meshes.files.items()})
        elif beside is not None:
            inside, there = posixpath.dirname(artifact.file) or ".", posixpath.dirname(place)
            data = {posixpath.relpath(name, inside): content for name, content in searched.files.items()}
            names = {name: posixpath.normpath(name) for name in beside(artifact.text)}
            copied = {name for name in names.values() if name in data and not name.startswith("..")}
            files.update({posixpath.join(there, name): data[name] for name in copied})
            for file, name in ((one.file, name) for one in searched.found for name in one.places):
                copy = posixpath.normpath(posixpath.join(there, posixpath.relpath(name, inside)))
                more = companions(copy, file) if copy in files else {}
                files.update({name: read_bytes(path) for name, path in more.items() if name.count("/") > 1})
            absent = [name for name, copy in names.items() if copy not in copied]
            diagnostics += missing_files(place, absent, placed, target)
        files[place] = artifact.text.encode()
    if carried is not None:
        needs.update(carried.packages)
        files.update(carried.files)
    files.update(_rendered(robot, options, urdf, placed, needs, target, carried, started))
    undecided = ["--maintainer"] if options.email == NO_MAIL else []
    undecided += ["--license"] if options.license == NO_LICENSE else []
    if undecided:
        message = f"package.xml does not name the maintainer or the license yet ({', '.join(undecided)})"
        help = "--maintainer 'NAME <MAIL>', --license with an SPDX name such as Apache-2.0"
        remarks.append(report("package-defaults", message, None, help))
    if options.license not in (*LICENSES, NO_LICENSE) and not is_file(target / LICENSE):
        message = f"there is no LICENSE in the package: the tool does not carry the text of {options.license}"
        help = f"put the text of the license into {target / LICENSE}; it stays there"
        remarks.append(report("package-license", message, None, help))
    return files, [*diagnostics, *remarks]


def folder_of(artifact: Artifact) -> str:
    """Return the folder of an artifact in a package, such as "urdf", from its format or its file extension."""
    file = artifact.file
    formats = (one.folder for one in FORMATS.values() if one.load and one.folder and file.endswith(one.endings))
    others = (folder for ending, folder in _BY_ENDING.items() if file.endswith(ending))
    return FORMATS[artifact.backend].folder or next(others, "") or next(formats, "config")


def _rendered(
    robot: Robot,
    options: Options,
    urdf: str,
    placed: Mapping[str, Artifact],
    needs: set[str],
    target: Path,
    carried: CarriedDescription | None,
    started: Bringup,
) -> dict[str, bytes]:
    rviz = file_name(f"{robot.name}.rviz", "robot.rviz")
    listed = [
        PackageFile(f"rviz/{rviz}", "rviz", "a view for RViz"),
        PackageFile(TEST, "test_urdf.py", "a test that the installed URDF parses: `colcon test`"),
        *launch_files(carried),
        *started.files(),
    ]
    contents = [(place, FORMATS[artifact.backend].about) for place, artifact in placed.items()]
    contents += [(one.place, one.about) for one in listed]
    contents += [(carried.description, "the description that is compiled at launch")] if carried else []
    folders = {*_FOLDERS, *(place.partition("/")[0] for place in placed)}
    folders |= {one.folder for one in FORMATS.values() if one.folder and FORMATS.is_own(one.name)}
    edges = [edge for edge in robot.edges if edge.publisher.kind != STATIC_TRANSFORM_PUBLISHER]
    others = [f"{one.parent} -> {one.child}: {one.publisher.name}{one.when and f', when {one.when}'}" for one in edges]
    values: dict[str, Any] = {
        "robot": robot,
        "package": {**asdict(options), "description": f"The robot {robot.name}."},
        "depends": sorted({*_NODES, *_LAUNCH, *needs}),
        "folders": sorted(folders | ({Description.FOLDER} if carried else set())),
        "urdf": urdf.removeprefix("urdf/"),
        "rviz": rviz,
        "literal": repr,
        "quoted": lambda text: Scalar(text).in_quotes(),
        "comment": Templates.comment,
        "contents": sorted(contents),
        "others": others,
        "holder": f"the authors of {options.name}" if options.maintainer == NOBODY else options.maintainer,
        "license_file": LICENSE if options.license in LICENSES or is_file(target / LICENSE) else "",
        **launch_values(robot, carried),
        **started.values(urdf),
        **_view(robot),
    }
    templates = {CHANGELOG: "CHANGELOG.rst"} | {one.place: one.template for one in listed}
    templates |= {LICENSE: f"licenses/{options.license}"} if options.license in LICENSES else {}
    templates |= {name: name for name in ("package.xml", "README.md", *_BUILT_BY[options.build_type])}
    texts = {name: Templates.own(f"ros/package/{template}.jinja", values) for name, template in templates.items()}
    made = {name: text.encode() for name, text in texts.items()}
    return made | ({f"resource/{options.name}": b""} if options.build_type == "ament_python" else {})


def _view(robot: Robot) -> dict[str, Any]:
    """Return the variables of the RViz template; sizes are rounded, so that small changes of a robot do not matter."""
    joints = robot.in_urdf()
    children = dict.fromkeys(joint.child for joint in joints)
    links = dict.fromkeys(joint.parent for joint in joints) | children
    root = next((link for link in links if link not in children), robot.root)
    reach = max([0.2, *(math.hypot(*robot.transform(robot.root, link, {}).xyz) for link in links)])
    size = float(f"{reach:.1g}")
    kinds = {port.type: port.display for port in ports("", node="rviz", direction=IN)}
    topics, displays = {one.name: full_topic(topic, "", "") for one, topic, _ in topics_of_sensors(robot)}, []
    for name, kind in ((one.name, kinds.get(message_of_sensor(one.type))) for one in robot.sensors):
        shown = {"name": name} if name in topics else {"name": f"{name} (choose its topic)"}
        displays += [{"kind": kind, "topic": topics.get(name, ""), **shown}] if kind else []
    return {
        "fixed_frame": root,
        "displays": displays,
        "visual": any(robot.link[link].visual for link in links or [root]),
        "size": float(f"{size / 2:.1g}"),
        "scale": min(1.0, size),
        "distance": float(f"{3 * size:.1g}"),
    }
