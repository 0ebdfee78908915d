"""Mesh copies: what was found elsewhere gets into the folder of the artifacts, as bytes that MuJoCo reads.

STL, OBJ and MSH are copied as they are, and so are textures, which are PNG. DAE, glTF and GLB become OBJ, and an STL of
letters, which MuJoCo does not read, one of bytes: trimesh reads them. What is written says of which bytes it was made
(SHA-256), and a machine without trimesh takes what is there. The numbers do not
depend on the machine.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .. import world
from ..diagnostics import ERROR, NOTE, WARNING, Diagnostic, has_errors
from ..diagnostics.progress import Progress
from ..diagnostics.registry import FORMATS, Rule
from ..formats.mesh_files import Found, Searched, files_diagnostic
from ..formats.mesh_triangles import ExtractProblem, load_mesh
from ..formats.named_files import OF_ELEMENT, Named
from ..world.listening import listening
from .mesh_soundness import MOST_FACES, NotSound, check, check_pointer, is_text

if TYPE_CHECKING:
    from ..formats.mesh_triangles import Floats

RULES = (
    Rule(
        "mesh-converted",
        "A note: a mesh is of a format that MuJoCo does not read; the MJCF names a copy in another one.",
        "Nothing is to be done; colours and textures of such a file are not carried over.",
        FORMATS,
        asked="meshes",
    ),
    Rule(
        "mesh-not-read",
        "A warning: a mesh or a texture cannot be read, or not by MuJoCo; it is left out of the MJCF. An error of one "
        "that an element of `mjcf_elements` names.",
        "As the message says.",
        FORMATS,
        asked="meshes",
    ),
)

MAX_BYTES = 500_000_000
_MARK = "made by rosorin-compile of SHA-256 "


def brought(searched: Searched, outputs: Path) -> Searched:
    """Return the meshes with the files that belong to the artifacts; what cannot be read is missing from now on."""
    if has_errors(searched.diagnostics):
        return searched
    files: dict[str, bytes] = {}
    missing = set(searched.missing)
    converted: list[Named] = []
    failed: dict[tuple[str, str, str], list[Named]] = {}
    for number, found in enumerate(searched.found):
        Progress.step("reading meshes", number, len(searched.found))
        try:
            files |= dict.fromkeys(found.beside, _read(found.file)) if found.beside else {}
            made, is_new = _files(found, outputs)
        except NotSound as problem:
            failed.setdefault((str(problem), problem.help, found.named.kind), []).append(found.named)
            missing.add(found.named.name)
            continue
        files |= made
        if is_new:
            converted.append(found.named)
    return searched._replace(
        missing=frozenset(missing), diagnostics=[*searched.diagnostics, *_said(failed, converted)], files=files
    )


def _said(failed: Mapping[tuple[str, str, str], Sequence[Named]], converted: Sequence[Named]) -> list[Diagnostic]:
    said = []
    for (what, help, kind), files in failed.items():
        severity, so = (ERROR, "not read") if kind == OF_ELEMENT else (WARNING, "left out of the MJCF")
        said.append(files_diagnostic("mesh-not-read", f"{so}: {what}", help, severity, files))
    if converted:
        what = "converted for the MJCF: MuJoCo reads binary STL, OBJ and MSH"
        said.append(replace(files_diagnostic("mesh-converted", what, "", NOTE, converted), related=()))
    return said


def _files(found: Found, outputs: Path) -> tuple[dict[str, bytes], bool]:
    """Return the files of a mesh by their names in the folder of the artifacts, and whether one was converted now.

    Raises NotSound.
    """
    data = _read(found.file)
    check_pointer(data)
    own = next((place for place in found.places if _is(outputs / place, found.file)), None)
    if own is not None:
        check(data, found.file.suffix.lower())
        return dict.fromkeys(found.places, data), False
    made: dict[str, bytes] = {}
    is_new = False
    for place in found.places:
        ending = Path(place).suffix.lower()
        if ending == found.file.suffix.lower() and not (ending == ".stl" and is_text(data)):
            check(data, ending)
            made[place] = data
        else:
            there, mark = _there(outputs / place), f"{_MARK}{hashlib.sha256(data).hexdigest()[:40]}"
            # Without trimesh what is there is taken for what its first line says.
            is_known = mark.encode() in there[:200] and not world.package("trimesh")
            made[place] = there if is_known else _converted(found.file, ending, mark)
            is_new = is_new or made[place] != there
            check(made[place], ending)
    if not found.places:
        check(data, found.file.suffix.lower())
    return made, is_new


def _is(path: Path, file: Path) -> bool:
    try:
        return world.is_same(path, file)
    except OSError:
        return False


def _read(path: Path) -> bytes:
    try:
        if world.size(path) > MAX_BYTES:
            raise NotSound(f"it is larger than {MAX_BYTES:,} bytes", "reduce the number of triangles")
        return world.read(path)
    except OSError as problem:
        reason = problem.strerror or type(problem).__name__
        raise NotSound(f"{reason}", "check the permissions") from None


def _there(path: Path) -> bytes:
    try:
        return world.read(path) if world.kind(path) == world.FILE else b""
    except (OSError, ValueError):
        return b""


@world.asked_again
def _converted(path: Path, ending: str, mark: str) -> bytes:
    """Return a mesh in another format, whose bytes the mark stands for. Raises NotSound."""
    try:
        with listening():  # trimesh opens what belongs to the file
            triangles = load_mesh(path).triangles
    except ExtractProblem as problem:
        said = problem.diagnostic
        raise NotSound(said.message.removeprefix(f"{path} "), said.help) from None
    if ending == ".stl" and len(triangles) > MOST_FACES:
        raise NotSound(f"it has more than {MOST_FACES:,} triangles", "export it as OBJ")
    return _WRITERS[ending](triangles, mark)


def _obj(triangles: Floats, mark: str) -> bytes:
    """Return triangles (n, 3, 3) as OBJ: each corner once, as many digits as MuJoCo keeps."""
    import numpy as np

    corners, faces = np.unique(triangles.reshape(-1, 3).astype(np.float32), axis=0, return_inverse=True)
    lines = [f"# {mark}", *("v " + " ".join(f"{value + 0.0:.9g}" for value in corner) for corner in corners.tolist())]
    lines += ["f " + " ".join(map(str, face)) for face in (faces.reshape(-1, 3) + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def _stl(triangles: Floats, mark: str) -> bytes:
    """Return triangles (n, 3, 3) as binary STL."""
    import numpy as np

    made = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    made["corners"] = triangles
    return mark.encode().ljust(80) + struct.pack("<I", len(triangles)) + made.tobytes()


_WRITERS: Mapping[str, Callable[[Floats, str], bytes]] = {".obj": _obj, ".stl": _stl}
