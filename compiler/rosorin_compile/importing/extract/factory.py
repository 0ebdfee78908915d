"""Extract joints, a bounding box for each link and a height map from a ROS description package.

Only numbers and names are extracted; no mesh and no text of the package is copied.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

from rosorin_compile.formats import FORMATS
from rosorin_compile.model.mesh_triangles import ExtractProblem, TriangleMesh
from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.request import FilePath, Packages, Values, Warn, read_options
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, DiagnosticError, RequestError, UnknownName, phrase
from rosorin_compile.source.messages import arrange
from rosorin_compile.source.packages import Packages as PackageFinder
from rosorin_compile.source.progress import Progress

from ..description import layout, plain_value
from .extract import MARK, RobotSource, all_diagnostics, is_made

_POSE = ("type", "parent", "child", "xyz", "rpy", "axis")
_KEYS = (*_POSE, "limit", "mimic", "dynamics", "calibration", "safety_controller")
_NOT_TAKEN = ("mass-", "inertia-", "shape-")  # prefixes of rule ids; these rules check values that are not extracted
_MAX_BYTES = 5_000_000  # size limit of a robot file
_ROBOT = re.compile(r"<robot\b[^>]*?\sname\s*=", re.DOTALL)
_INCLUDES = re.compile(r"<xacro:include\b[^>]*?\sfilename\s*=\s*[\"']([^\"']+)[\"']", re.DOTALL)
_CONDITION = re.compile(r"""(?s)<xacro:(if|unless)\b[^>]*?\svalue\s*=\s*("[^"]*"|'[^']*')[^>]*>(.*?)</xacro:\1>""")
_PROPERTY = re.compile(r"<xacro:property\b[^>]*?\sname\s*=\s*[\"'](\w+)[\"'][^>]*?\svalue\s*=\s*[\"']([^\"']*)[\"']")
_VARIABLE = re.compile(r"""\$\((env|optenv|arg)\s+(\w+)[^()]*\)\s*['"]?\s*(?:[!=]=\s*['"]([^'"]*)['"])?""")


@dataclass(frozen=True)
class ExtractedFactory:
    """The result of ``extract_factory``: the extracted joints, the links with a box, and the written files."""

    joints: tuple[str, ...] = ()
    boxes: Annotated[tuple[str, ...], "the links that have one"] = ()
    written: Annotated[tuple[str, ...], "the files that were written"] = ()
    report: Annotated[tuple[str, ...], "what was found, in sentences"] = ()
    diagnostics: tuple[Diagnostic, ...] = field(default=(), repr=False)


def extract_factory(
    package: FilePath,
    output: FilePath,
    arguments: Values = None,
    packages: Packages = None,
    *,
    robot: str | None = None,
    height_map_link: str | None = None,
    frame: str | None = None,
    section: str = "auto",
    cell: float | None = None,
    origin: tuple[float, float] | None = None,
    cells: tuple[int, int] | None = None,
    size: tuple[float, float] | None = None,
    below: float | None = None,
    map_digits: int = 4,
    step: float | None = None,
    lenient: bool = False,
    trust: bool = False,
    warn: Warn = None,
) -> ExtractedFactory:
    """Write the joints, a box for each link and a height map of a ROS description package to YAML files.

    Options that are not listed here are the same as in ``extract_height_map``.

    Args:
        package: The folder of the package.
        output: The folder of the YAML files.
        robot: The robot file in the package; by default the only one.
        height_map_link: The link whose meshes are used for a height map. Default: no height map.
        frame: The link whose frame the height map uses; by default ``height_map_link``.
        lenient: Accept violations of the specification where possible.
    """
    reading, wrong = read_options(arguments, packages, trust, warn, lenient)
    if wrong:
        return ExtractedFactory(diagnostics=tuple(wrong))
    if frame and not height_map_link:
        raise RequestError("--frame is that of the height map; name its link: --heightmap-link LINK")
    frame, folder = frame or height_map_link, Path(package)
    path, diagnostics = None, list[Diagnostic]()
    try:
        TriangleMesh.require_packages()
        from .height_map import GridOptions, height_map_yaml, make_height_map, summary
        from .shapes import enclosing_box

        grid = GridOptions(cell, origin, cells, size, below, map_digits, step)
        path = _find_robot_file(folder, robot)
        name = PackageFinder.name_of(folder) or files.resolve(folder).name
        source = RobotSource(str(path), reading._replace(packages={name: folder, **reading.packages}), diagnostics)
        for link in filter(None, (height_map_link, frame)):
            source.link(link)
        boxes: dict[str, Any] = {}
        for index, link in enumerate(source.robot.link):
            Progress.step("measuring", index, len(source.robot.link))
            part = None if link == height_map_link else source.part(link, section)
            if part is not None:
                box = enclosing_box(part.triangles, digits=5)
                boxes[link] = {"collision": [{"box": {"min": plain_value(box.lower), "max": plain_value(box.upper)}}]}
        texts, lines = dict[str, str](), list[str]()
        if height_map_link is not None and frame is not None:
            part = source.part(height_map_link, section)
            try:
                if part is None:
                    message = f"{height_map_link} has no mesh that can be read: no height map"
                    raise ExtractProblem.new("height-map-empty", message)
                transform = source.robot.transform(frame, height_map_link, {})
                triangles = TriangleMesh.place(part.triangles, transform.rows, transform.xyz)
                height_map, messages = make_height_map(triangles, grid, frame)
                note = f"top of {', '.join(part.meshes)}"
                texts["heightmap"] = height_map_yaml(frame, height_map, "calculated", note)
                lines.append(f"height map in {frame}: {summary(height_map)}")
                diagnostics += messages
            except ExtractProblem as problem:
                diagnostics.append(problem.diagnostic)
        # Keep the ``accept`` entries (suppressed diagnostics), because the joint values are copied unchanged.
        joints = {
            joint: {key: plain_value(value) for key, value in entry.items() if key in _KEYS}
            for joint, entry in (source.tree.get("joints") or {}).items()
        }
        accepted = [one for one in source.tree.get("accept") or () if not one["rule"].startswith(_NOT_TAKEN)]
        document = {"source": {"status": "factory", "note": f"description package {name}"}, "joints": joints}
        texts["joints"] = layout({**document, "accept": plain_value(accepted)} if accepted else document)
        linked = [link for link in source.robot.link if link in boxes or not (lines and link == frame)]
        links = {link: boxes.get(link, {}) for link in linked}
        note = f"boxes around the meshes of the package {name}"
        texts["boxes"] = layout({"source": {"status": "calculated", "note": note}, "links": links})
        head = f"{MARK} factory: %s of the package {name}. Numbers only; metres, radians.\n"
        written = {f"{title}.yaml": head % title + text for title, text in sorted(texts.items())}
        write_set(Path(output), written, judge=lambda _, old, __: "replace" if is_made(old) else "refuse")
    except DiagnosticError as problem:
        if path is not None and (choice := _choice(_read(path))):
            help = "set the environment variable, or give the argument as NAME:=VALUE"
            diagnostics.append(Diagnostic("factory-robot", NOTE, f"{path} {choice}", help=help))
        return ExtractedFactory(diagnostics=all_diagnostics(problem, diagnostics))
    places = tuple(str(Path(output) / file) for file in written)
    names = (("joints", tuple(source.robot.joint)), ("boxes", tuple(boxes)))
    report = [f"{what} ({len(found)}): {', '.join(found) or 'none'}" for what, found in names]
    report += [*lines, f"written: {', '.join(places)}"]
    return ExtractedFactory(tuple(source.robot.joint), tuple(boxes), places, tuple(report), tuple(arrange(diagnostics)))


def _find_robot_file(package: Path, requested: str | None) -> Path:
    if not files.is_folder(package):
        raise RequestError(f"{package} is not a folder; name the folder of a description package")
    endings = FORMATS.endings()
    paths = [path for path in sorted(package.glob("**/*")) if path.suffix.lower() in endings and files.is_file(path)]
    texts = {path: _read(path) for path in paths}
    included: set[Path] = set()
    for path, text in texts.items():
        for address in _INCLUDES.findall(text):
            # An expression in a file name, as in ${model}.xacro or $(arg model).xacro, matches any text.
            pieces = re.split(r"\$\{[^}]*\}|\$\([^)]*\)", address.rpartition("/")[2])
            pattern = re.compile(".+".join(map(re.escape, pieces)))
            included |= {other for other in texts if other != path and pattern.fullmatch(other.name)}
    candidates = [path for path, text in texts.items() if _ROBOT.search(text) and path not in included]
    choices = {path: choice for path in texts if path not in included and (choice := _choice(texts[path]))}
    if len(candidates) != 1:
        candidates = sorted({*candidates, *choices})
    names = [str(path.relative_to(package)) for path in candidates]
    if requested is not None:
        for path in (package / requested, Path(requested)):
            if files.is_file(path):
                return path
        raise UnknownName("file", requested, names, str(package))
    if len(candidates) == 1:
        return candidates[0]
    if not candidates:
        raise ExtractProblem.new("factory-robot", f"{package} has no file of a robot", "name one with --robot FILE")
    message = f"{package} has {len(names)} files of robots: {', '.join(names[:20])}"
    help = "select one with --robot FILE"
    if choices:
        message += "".join(f"; {path.relative_to(package)} {text}" for path, text in choices.items())
        help = f"use the file that chooses: --robot {next(iter(choices)).relative_to(package)}; or {help}"
    raise ExtractProblem.new("factory-robot", message, help)


def _choice(text: str) -> str:
    """Describe the arguments and environment variables that select the included files, with possible values."""
    includes = _INCLUDES.findall(text)
    conditions = [value[1:-1] for _, value, content in _CONDITION.findall(text) if "<xacro:include" in content]
    conditions += [name for name in includes if "$" in name]
    properties = {
        name: f"$({variable[1]} {variable[2]})"
        for name, value in _PROPERTY.findall(text)
        if (variable := _VARIABLE.search(value))
    }
    values: dict[str, dict[str, None]] = {}
    for condition in conditions:
        expanded = re.sub(r"\w+", lambda word: properties.get(word[0], word[0]), condition)
        for source, name, value in _VARIABLE.findall(expanded):
            kind = "argument" if source == "arg" else "environment variable"
            values.setdefault(f"the {kind} {name}", {}).update({value: None} if value else {})
    chosen = [f"{name} ({', '.join(some)})" if some else name for name, some in values.items()]
    return f"chooses by {phrase(chosen)}" if chosen else ""


def _read(path: Path) -> str:
    return files.read_bytes(path, _MAX_BYTES).decode("utf-8", "replace")
