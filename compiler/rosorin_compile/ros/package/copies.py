"""Find and compare copies of artifacts (compiled files) in a folder, and copy their meshes into a package.

``package://`` URIs of meshes in other packages are not changed, and these packages become dependencies. Meshes with
relative paths are copied and get ``package://`` URIs, because robot_state_publisher gets the URDF without its path.
"""

import posixpath
import re
from collections import defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple
from xml.sax.saxutils import unescape

from rosorin_compile.compare.golden_check import NOT_TEXT, Comparison, compare, shorten
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.formats.mesh_files import references, urdf_file_name
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Robot
from rosorin_compile.output.atomic_files import digest, is_generated, kept_name
from rosorin_compile.rules.case import report
from rosorin_compile.source.diagnostics import Diagnostic, first_of, printable
from rosorin_compile.source.files import is_file, read_bytes

from .options import NOWHERE, is_legal

_FILE = re.compile(r"""(<(?:mesh|texture)\b[^<>]*?\bfilename=["'])([^"'<>]*)(?=["'])""")
_OF_SDF = re.compile(r"(<(?:mesh>\s*<uri|albedo_map|normal_map|metalness_map|roughness_map)>\s*)([^<>]*?)(?=\s*</)")
_ENTITIES = {"&quot;": '"', "&apos;": "'", "&#34;": '"', "&#39;": "'"}
MESHES = "meshes"


class Meshes(NamedTuple):
    """A URDF or SDF with new mesh paths, and the mesh files to copy into the package."""

    text: str
    files: dict[str, Path]  # path in the package -> file to copy
    packages: tuple[str, ...]  # names of other packages that contain meshes
    diagnostics: list[Diagnostic]


def file_names(text: str, is_sdf: bool = False) -> list[str]:
    """Return the unique mesh and texture file names in a URDF or SDF, in document order."""
    return list(dict.fromkeys(unescape(match[2], _ENTITIES) for match in (_OF_SDF if is_sdf else _FILE).finditer(text)))


def place_meshes(
    text: str,
    package: str,
    folders: Sequence[Path],
    target: Path,
    known: Mapping[str, Path] = MappingProxyType({}),
    reported: Container[str] = (),
    place: str = "",
) -> Meshes:
    """Change mesh names in a URDF to ``package://`` URIs, or in an SDF at ``place`` to paths relative to the SDF.

    Meshes are looked up in ``known`` (files by name), in ``folders``, and in the package folder ``target``. Missing
    meshes cause a warning unless their names are in ``reported``.
    """
    addresses, files, packages = dict[str, str](), dict[str, Path](), set[str]()
    missing: dict[tuple[str, str], list[str]] = defaultdict(list)  # file names by (problem, help)
    where = "neither in the package nor next to the description" if folders else "not in the package"
    is_sdf = place.endswith(".sdf")
    for name in file_names(text, is_sdf):
        is_copied = is_sdf and name in known
        match = None if is_copied else re.fullmatch(r"package://([^/]+)/(.+)", name)
        if match and match[1] != package:
            packages |= {match[1]} if is_legal(match[1]) else set()
            continue
        if not match and not is_copied and ("://" in name or name.startswith("/")):
            help = f"copy the file into a package and write package://{package}/{MESHES}/... in the description"
            missing["found on machines that have this very file", help].append(name)
            continue
        inside = searched = match[2] if match else name
        if not match:
            parts = [part for part in urdf_file_name(name).split("/") if part not in ("", ".", "..")]
            inside = "/".join([MESHES, *(parts[1:] if parts[0] == MESHES and len(parts) > 1 else parts)])
            relative = posixpath.relpath(inside, posixpath.dirname(place))
            addresses[name] = relative if is_sdf else f"package://{package}/{inside}"
        leads_out = ".." in inside.split("/")
        source = known.get(name) or next((one / searched for one in folders if is_file(one / searched)), None)
        if source is not None and not leads_out:
            files[inside] = source
        elif name not in reported and (leads_out or not is_file(target / inside)):
            missing[where, f"put the file into {posixpath.dirname(inside) or '.'}/ of the package"].append(name)
    named = [(inside, *one) for inside, source in files.items() for one in companions(inside, source).items()]
    files |= {name: file for _, name, file in named if name.startswith(f"{MESHES}/")}
    for inside, name in [(inside, name) for inside, name, _ in named if not name.startswith(f"{MESHES}/")]:
        help = f"put the file below the folder of the mesh: a package installs {MESHES}/"
        missing[f"named by {inside} and not in the package", help].append(name)

    def renamed(match: re.Match[str]) -> str:
        name = addresses.get(unescape(match[2], _ENTITIES))
        return match[0] if name is None else f"{match[1]}{escape(name)}"

    text = (_OF_SDF if is_sdf else _FILE).sub(renamed, text)
    diagnostics = [_mesh_warning(names, what, help) for (what, help), names in missing.items()]
    return Meshes(text, files, tuple(sorted(packages)), diagnostics)


def companions(place: str, mesh: Path) -> dict[str, Path]:
    """Return the existing files that a mesh at ``place`` refers to, such as textures, by path in the package."""
    found = {name: mesh.parent / name for name in references(mesh) if is_file(mesh.parent / name)}
    return {posixpath.normpath(posixpath.join(posixpath.dirname(place), name)): file for name, file in found.items()}


def missing_files(place: str, names: Sequence[str], places: Container[str], folder: Path) -> Iterator[Diagnostic]:
    """Yield a warning if files that an artifact at ``place`` refers to are neither in ``places`` nor in ``folder``."""
    inside = posixpath.dirname(place)
    needed = [name for name in names if posixpath.normpath(posixpath.join(inside, name)) not in places]
    if missing := [name for name in needed if not is_file(folder / inside / name)]:
        what = f"named by {place}, but not in the package"
        yield _mesh_warning(missing, what, f"put the file into {inside}/ of the package")


def _mesh_warning(names: Sequence[str], what: str, help: str) -> Diagnostic:
    message = f"{names[0]} is {what}"
    if len(names) > 1:
        message = f"{len(names)} files are {what}: {first_of(names, 3)}".replace("this very file", "these very files")
        help = help.replace("the file", "the files")
    return report("package-mesh", message, None, help)


_HEAD = 4096  # bytes at the start of a file, which contain the "Generated by" comment
_MARK = "Generated by rosorin-compile from the description of {}; edits"


def copies(folder: Path, files: Sequence[str], robot: str, artifact: Artifact, every: Sequence[Artifact]) -> list[str]:
    """Return the files that are copies of an artifact, by their names or their "Generated by" comments.

    A file with the name of another artifact in ``every`` is a copy of that artifact. Copies of a ``withheld`` artifact,
    which nodes must not load, are recognized by name only, so that the artifact never replaces a file that nodes load.
    """
    format, own = FORMATS[artifact.backend], artifact.file.rpartition("/")[2]
    taken = {one.file.rpartition("/")[2] for one in every}

    def is_copy(file: str) -> bool:
        name = file.rpartition("/")[2]
        if name == own or artifact.withheld or name in taken or not file.endswith(format.endings):
            return name == own
        try:
            if format.robot_of is not None:
                return format.robot_of(folder / file) == robot
            head = read_bytes(folder / file, _HEAD).decode("utf-8", "replace")
        except OSError:
            return False
        is_ours = any(_MARK.format(name) in head for name in (robot, repr(robot)))
        is_of_package = format.located and "get_package_share_directory" in head
        return is_ours and not is_of_package and (not format.roots or any(f"<{root}" in head for root in format.roots))

    return sorted(filter(is_copy, files))


def other_robot(path: Path, robot: str) -> str:
    """Return the name of the other robot that a file was generated for, or "" if there is none. Raises OSError."""
    if not is_file(path):
        return ""
    match = re.search(_MARK.format("(.+)"), read_bytes(path, _HEAD).decode("utf-8", "replace"))
    readers = (one.robot_of for one in FORMATS.values() if one.robot_of is not None and path.name.endswith(one.endings))
    name = match[1] if match else next(filter(None, (read(path) for read in readers)), "")
    same = (robot, repr(robot), Templates.comment(robot), "the robot")  # "the robot" for an unnamed robot
    return "" if name in same else name.strip("'\"")


def difference(robot: Robot, artifact: Artifact, old: bytes) -> Comparison | None:
    """Compare an artifact with the bytes of an existing copy; return None if they are equal."""
    if old == artifact.text.encode():
        return None
    comparison, texts = compare(robot, [artifact], {artifact.file: old}), []
    for one in comparison.texts:
        lines = tuple(line.replace("--- committed/", "--- deployed/", 1) for line in one.lines)
        remark = one.remark.replace("the committed file", "the file") if one.kind != NOT_TEXT else "no UTF-8 text"
        texts.append(one._replace(remark=remark, lines=lines))
    return comparison._replace(texts=tuple(texts))


def diff_lines(place: str, found: Comparison, full: bool) -> list[str]:
    """Format a comparison as lines that begin with the path ``place``; if ``full``, text diffs are not shortened."""
    meaning = [*(change.text for change in found.changes), *(text.remark for text in found.texts if text.remark)]
    lines = [f"{printable(place)}: {line}" for line in meaning or ["same meaning, different text"]]
    return lines + [line for one in found.texts[:1] for line in (one.lines if full else shorten(one.lines))]


def relocate(robot: Robot, artifact: Artifact, place: str, urdf: str) -> Artifact:
    """Return an artifact for the path ``place``. A launch file is changed to load the URDF at the path ``urdf``."""
    if not FORMATS[artifact.backend].located or not urdf:
        return replace(artifact, file=place)
    names = {output.name: urdf for output in FORMATS.outputs_read_by(robot, ROBOT_STATE_PUBLISHER)} | {
        artifact.output: place
    }
    outputs = tuple(replace(one, file=names.get(one.name, one.file)) for one in robot.outputs)
    output = next(one for one in outputs if one.name == artifact.output)
    text = FORMATS[artifact.backend].compile(replace(robot, outputs=outputs), output, Templates())[0]
    return replace(artifact, file=place, text=text)


def forms(robot: Robot, artifact: Artifact, place: str, urdfs: Iterable[str], package: str) -> list[Artifact]:
    """Return all valid versions of a copy at ``place``, most likely first.

    A launch file may load any of ``urdfs``. The meshes in a URDF may have ``package://`` URIs in ``package``.
    """
    folder, plain = posixpath.dirname(place) or ".", replace(artifact, file=place)
    near = sorted(urdfs, key=lambda urdf: (len(posixpath.relpath(urdf, folder)), urdf))
    found = [relocate(robot, artifact, place, urdf) for urdf in near if FORMATS[artifact.backend].located]
    if FORMATS.names_meshes(artifact) and package:
        found.append(replace(plain, text=place_meshes(artifact.text, package, (), Path(folder)).text))
    return [*found, plain]


def protect(
    folder: Path, files: Mapping[str, bytes], digests: Mapping[str, Sequence[str]], own_package: bool = False
) -> tuple[dict[str, bytes], list[Diagnostic]]:
    """Return (backups by path, diagnostics); the backups are edited files that ``files`` would replace.

    ``digests`` are digests of the files that this tool wrote. Replacing a file without a digest is an error, except in
    a package that the tool created (``own_package``): older versions did not record digests. Raises OSError.
    """
    copies, diagnostics = dict[str, bytes](), list[Diagnostic]()
    for name, new in files.items():
        path, is_listed = folder / name, name in digests
        old = path.read_bytes() if path.is_file() and not path.is_symlink() else new
        is_written = digest(old) in digests.get(name, ()) or (not is_listed and is_generated(old))
        if old == new or not old.strip() or is_written:
            continue
        if not is_listed and is_generated(new) and not own_package:
            message = f"this tool did not write {name}: it is not replaced"
            help = f"move it away, or say another place with --map OUTPUT=PLACE ({NOWHERE} for nowhere)"
            diagnostics.append(report("deploy-not-ours", message, None, help))
            continue
        copy = Path(name).with_name(kept_name(path, old).name).as_posix()
        copies[copy] = old
        why = "was changed since this tool wrote it" if is_listed else "has no mark of this tool"
        end = "remove that file"
        help = f"bring the change into the description, and {end}" if is_listed else f"{end} if it is not needed"
        diagnostics.append(report("deploy-kept", f"{name} {why}; as it was, it goes to {copy}", None, help))
    return copies, diagnostics
