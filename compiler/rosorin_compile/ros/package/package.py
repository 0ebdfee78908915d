"""Package: the files of a ROS 2 package that carries the artifacts of a robot, starts its nodes and shows it."""

from __future__ import annotations

import dataclasses
import posixpath
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.mesh_files import urdf_file_name
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, STATIC_TRANSFORM_PUBLISHER, Edge, Robot
from rosorin_compile.source.diagnostics import Diagnostic, error, has_errors
from rosorin_compile.source.files import is_file, read_bytes
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.yaml_text import Scalar

from . import meshes, papers, starting, views
from .bringup import Bringup, bringup
from .naming import file_name

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled

    from .carrying import Carried

RULES = (
    Rule("package-no-urdf", "No output is a URDF.", "Add an output with the backend `urdf`.", Heading.PACKAGES),
    Rule(
        "package-same-place",
        "Two outputs have one file name in two folders, and a package has one folder for both.",
        "Let the file names differ.",
        Heading.PACKAGES,
    ),
)


BUILD_TYPES = ("ament_cmake", "ament_python")
_BUILT_BY = {"ament_cmake": ("CMakeLists.txt",), "ament_python": ("setup.py", "setup.cfg")}
FOLDERS = ("config", "doc", "launch", "meshes", "rviz")  # beside those that formats ask for
_NODES = ("robot_state_publisher", "tf2_ros")
# Where what a format does not place stands, by the ending of its file.
_BY_ENDING = {".rviz": "rviz", ".launch.py": "launch"}
_BY_ENDING |= dict.fromkeys((".dot", ".html", ".md", ".mmd", ".svg"), "doc")


@dataclasses.dataclass(frozen=True)
class Options:
    """What a package is called and what its package.xml says; ``topics`` are topics by the name of the sensor.

    ``at_launch`` says that it compiles its description whenever it is launched, ``starts`` what it starts besides the
    publishers (``naming.STARTS``).
    """

    name: str
    build_type: str = BUILD_TYPES[0]
    version: str = "0.1.0"
    maintainer: str = papers.NOBODY
    email: str = papers.NO_MAIL
    license: str = papers.NO_LICENSE
    url: str = ""
    at_launch: bool = False
    starts: tuple[str, ...] = ()
    description: str = ""
    topics: Mapping[str, str] = dataclasses.field(default_factory=dict)


class Package(NamedTuple):
    """The files of a package, bytes by relative name, and what is to say about them."""

    files: dict[str, bytes]
    diagnostics: list[Diagnostic]


def make(
    robot: Robot,
    artifacts: Sequence[Artifact],
    options: Options,
    sources: Sequence[Path],
    target: Path,
    compiled: Compiled | None = None,
    carried: Carried | None = None,
) -> Package:
    """Return the package of a robot that was ``compiled``, its meshes searched; ``carried`` is compiled at launch.

    ``sources`` are folders in which other files are looked for that the description names; ``target`` is where the
    package will stand, which may hold such files already.
    """
    main = next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if main is None:
        help = f"add an output with the backend {FORMATS.published().name}"
        return Package(
            {}, [error("package-no-urdf", "no output is a URDF, and a package is nothing without", None, help)]
        )
    placed, twice = _placed(artifacts, main)
    started, missing = bringup(robot, placed, options.starts)
    if twice or missing:
        return Package({}, [one for one in (twice, missing) if one])
    open_ends = started.open_ends(options.topics)
    if has_errors(open_ends):
        return Package({}, open_ends)
    files: dict[str, bytes] = {}
    needs: set[str] = set(started.packages())
    diagnostics: list[Diagnostic] = []
    searched = None if compiled is None else compiled.meshes
    found: dict[str, Path] = {} if searched is None else dict(searched.by_name)
    found |= {urdf_file_name(name): file for name, file in found.items()}
    lost = frozenset[str]() if searched is None else searched.missing
    for place, artifact in placed.items():
        named_beside = FORMATS[artifact.backend].beside
        if FORMATS.names_meshes(artifact):
            settled = meshes.settle(artifact.text, options.name, sources, target, found, lost, place)
            artifact = dataclasses.replace(artifact, text=settled.text)
            needs.update(settled.packages)
            diagnostics += settled.diagnostics
            files.update({name: read_bytes(path) for name, path in settled.files.items()})
        elif named_beside is not None:
            left = _left(place, artifact, named_beside, {} if searched is None else searched.files, sources, files)
            folder = artifact.file.rpartition("/")[0]
            for one in () if searched is None else searched.found:
                for name in one.places:
                    copy = posixpath.normpath(
                        posixpath.join(posixpath.dirname(place), posixpath.relpath(name, folder or "."))
                    )
                    more = meshes.companions(copy, one.file) if copy in files else {}
                    files.update({there: read_bytes(file) for there, file in more.items() if there.count("/") > 1})
            diagnostics += meshes.named_files(place, meshes.not_placed(place, left, placed), target)
        files[place] = artifact.text.encode()
    if carried is not None:
        needs.update(carried.packages)
        files.update(carried.files)
    files.update(_made(robot, options, place_of(main, main), list(placed.items()), needs, target, carried, started))
    return Package(files, [*diagnostics, *open_ends, *started.remarks(), *papers.remarks(options, target)])


def _placed(artifacts: Sequence[Artifact], main: Artifact) -> tuple[dict[str, Artifact], Diagnostic | None]:
    """Return artifacts by their places in a package, and what is wrong where two have one."""
    placed: dict[str, Artifact] = {}
    for artifact in artifacts:
        place = place_of(artifact, main)
        if place and placed.setdefault(place, artifact) is not artifact:
            return placed, _twice(place, placed[place], artifact)
    return placed, None


def _left(
    place: str,
    artifact: Artifact,
    beside: Callable[[str], Iterable[str]],
    data: Mapping[str, bytes],
    sources: Sequence[Path],
    files: dict[str, bytes],
) -> list[str]:
    """Copy the files that an artifact has beside it into ``files``; return the names of those that are not found.

    ``data`` are mesh files by their names in the folder of the artifacts.
    """
    known = _meshes(artifact, data)
    return [name for name in dict.fromkeys(beside(artifact.text)) if not _copied(place, name, known, sources, files)]


def _twice(place: str, one: Artifact, other: Artifact) -> Diagnostic:
    message = f"the outputs {one.output} and {other.output} would both be {place} in the package"
    return error("package-same-place", message, None, "let their file names differ, not their folders alone")


def place_of(artifact: Artifact, main: Artifact) -> str:
    """Return where an artifact stands in a package; empty for the launch file, which the package has of its own."""
    if FORMATS[artifact.backend].located:
        return ""
    otherwise = FORMATS.published().file.format("robot") if artifact is main else artifact.file.rpartition("/")[2]
    return f"{folder_of(artifact)}/{file_name(artifact.file, otherwise)}"


def folder_of(artifact: Artifact) -> str:
    """Return the folder of an artifact: as its format says, else by the ending of its name."""
    own, file = FORMATS[artifact.backend].folder, artifact.file
    if own:
        return own
    formats = (one.folder for one in FORMATS.values() if one.load and one.folder and file.endswith(one.endings))
    others = (folder for ending, folder in _BY_ENDING.items() if file.endswith(ending))
    return next(others, "") or next(formats, "config")


def _meshes(artifact: Artifact, files: Mapping[str, bytes]) -> Mapping[str, bytes]:
    """Return the mesh files that belong to an artifact, by their names as seen from it."""
    folder = artifact.file.rpartition("/")[0]
    return {posixpath.relpath(name, folder or "."): data for name, data in files.items()}


def _copied(
    place: str, name: str, found: Mapping[str, bytes], sources: Sequence[Path], files: dict[str, bytes]
) -> bool:
    """Copy a file that an artifact names beside it; say whether it is known."""
    if name.startswith("/") or ".." in name.split("/"):
        return False
    data = found.get(posixpath.normpath(name))
    if data is None:
        source = next((folder / name for folder in sources if is_file(folder / name)), None)
        data = None if source is None else read_bytes(source)
    if data is not None:
        files[posixpath.join(posixpath.dirname(place), posixpath.normpath(name))] = data
    return data is not None


def _made(
    robot: Robot,
    options: Options,
    urdf: str,
    placed: Sequence[tuple[str, Artifact]],
    needs: set[str],
    target: Path,
    carried: Carried | None,
    started: Bringup,
) -> dict[str, bytes]:
    """Return the files that are made for the package alone."""
    package = options if options.description else dataclasses.replace(options, description=f"The robot {robot.name}.")
    rviz = "robot.rviz" if "/" in robot.name else file_name(f"{robot.name}.rviz", "robot.rviz")
    launch = ("ament_index_python", "launch", "launch_ros", "launch_xml", "launch_yaml", "ros2launch")
    values: dict[str, Any] = {
        "robot": robot,
        "package": dataclasses.asdict(package),
        "depends": sorted({*_NODES, *launch, *needs}),
        "folders": _folders(placed, carried),
        "urdf": urdf.removeprefix("urdf/"),
        "rviz": rviz,
        "literal": repr,
        "quoted": lambda text: Scalar(text).quoted(),
        "comment": Templates.comment,
        "contents": sorted([*_contents(placed, rviz, carried), *started.contents()]),
        "others": [_other(edge) for edge in robot.edges if edge.publisher.kind != STATIC_TRANSFORM_PUBLISHER],
        **starting.values(robot, carried, options.name),
        **started.values(urdf),
        **papers.values(options, target),
        **views.view(robot, options.topics),
    }
    templates = {f"rviz/{rviz}": "rviz"}
    templates |= {name: name for name in ("package.xml", "README.md", *_BUILT_BY[options.build_type])}
    templates |= starting.templates(carried) | papers.templates(options) | started.templates()
    texts = {name: Templates.own(f"ros/package/{template}.jinja", values) for name, template in templates.items()}
    made = {name: text.encode() for name, text in texts.items()}
    return made | ({f"resource/{options.name}": b""} if options.build_type == "ament_python" else {})


def _folders(placed: Sequence[tuple[str, Artifact]], carried: Carried | None) -> list[str]:
    """Return the folders that a package installs: those of the tool's own formats, and those of its artifacts."""
    own = (one.folder for one in FORMATS.values() if one.folder and FORMATS.is_own(one.name))
    more = [Description.FOLDER] if carried else []
    return sorted({*FOLDERS, *own, *more, *(place.partition("/")[0] for place, _ in placed)})


def _contents(placed: Sequence[tuple[str, Artifact]], rviz: str, carried: Carried | None) -> list[tuple[str, str]]:
    """Return the files of a package with what each is."""
    rows = [(place, FORMATS[artifact.backend].about) for place, artifact in placed]
    rows += [(f"rviz/{rviz}", "a view for RViz"), (papers.TEST, "a test that the installed URDF parses: `colcon test`")]
    return sorted([*rows, *starting.contents(carried)])


def _other(edge: Edge) -> str:
    when = f", when {edge.when}" if edge.when else ""
    return f"{edge.parent} -> {edge.child}: {edge.publisher.name}{when}"
