"""Soundness: whether MuJoCo reads a mesh or a texture, before an MJCF names it; the reason and the way out if not.

A file that was cut off, a pointer of Git LFS or a page that says 404 is no mesh whatever its name; one corner that is
no number is enough for MuJoCo 4.0.0 to refuse the whole model. Meshes are large: where it can be, bytes are looked at
as they are, and numbers only where a letter in them says that one may be wrong.
"""

from __future__ import annotations

import re
import struct
import zlib
from array import array
from collections.abc import Callable, Iterable, Mapping
from sys import byteorder

MOST_FACES = 200_000  # of an STL
FARTHEST = 2.0**30  # from the middle, in the units of the file, of a corner of an STL; what is beyond it has no hull
FEWEST = 4  # corners
HEAD = 84  # bytes of an STL before its triangles, of which each has 50
_ANEW = "export it anew"
_PNG = b"\x89PNG\r\n\x1a\n"
_POINTER = b"version https://git-lfs"
_MSH = struct.Struct("<4i")  # how many vertices, normals, texture coordinates and faces
_TRIANGLE = struct.Struct("<12x9f2x")
# The highest bytes of floats up to FARTHEST, of both signs.
_NEAR = bytes(byte for byte in range(256) if byte & 0x7F < 0x4E)
_CORNER = re.compile(rb"^[ \t]*v[ \t]+([^\r\n]*)", re.MULTILINE)
_DOUBTFUL = re.compile(rb"^[ \t]*v[ \t][^\r\n]*(?:[a-df-zA-DF-Z,]|\d{10}|[eE]\+?0*[1-9])", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t]+([^\r\n]*)", re.MULTILINE)
_INDEX = re.compile(rb"(?:^|(?<=[ \t]))(-?\d+)", re.MULTILINE)


class NotSound(Exception):
    """A file that MuJoCo does not read; the message ends a sentence about it, ``help`` is the way out."""

    def __init__(self, what: str, help: str = _ANEW) -> None:
        super().__init__(what)
        self.help = help


def check(data: bytes, ending: str) -> None:
    """Raise NotSound for what MuJoCo does not read; ``ending`` is that of the name, such as ".stl"."""
    if not data.strip():
        raise NotSound("the file is empty")
    check_pointer(data)
    if ending in _CHECKS:
        _CHECKS[ending](data)


def check_pointer(data: bytes) -> None:
    """Raise NotSound for what stands for a file that has not been fetched."""
    if data.startswith(_POINTER):
        raise NotSound("it is a pointer of Git LFS, not the file itself", "fetch the file: git lfs pull")


def is_text(data: bytes) -> bool:
    """Say whether an STL is one of letters: its size is not that of as many triangles as it says."""
    binary = len(data) >= HEAD and len(data) == HEAD + 50 * struct.unpack("<I", data[80:HEAD])[0]
    return not binary and data.lstrip()[:5].lower() == b"solid"


def _stl(data: bytes) -> None:
    if is_text(data):
        raise NotSound("MuJoCo reads no STL of letters", "export it anew, as binary STL")
    count = struct.unpack("<I", data[80:HEAD])[0] if len(data) >= HEAD else 0
    if len(data) != HEAD + 50 * count:
        raise NotSound("the STL is damaged")
    if not 1 <= count <= MOST_FACES:
        help = "reduce the number of triangles, or export it as OBJ"
        raise NotSound(f"it has {count:,} triangles, and MuJoCo takes 1 to {MOST_FACES:,} of an STL", help)
    triangles = data[HEAD:]
    if any(triangles[first::50].translate(None, _NEAR) for first in range(15, 51, 4)):
        _check_near(number for nine in _TRIANGLE.iter_unpack(triangles) for number in nine)
    _check_enough(corner for nine in _TRIANGLE.iter_unpack(triangles) for corner in (nine[:3], nine[3:6], nine[6:]))


def _obj(data: bytes) -> None:
    corners = sum(1 for _ in _CORNER.finditer(data))
    if not corners:
        raise NotSound("it is no OBJ: it has no corner")
    _check_enough(tuple(corner[1].split()[:3]) for corner in _CORNER.finditer(data))
    if _DOUBTFUL.search(data):
        try:
            _check_near(float(word) for corner in _CORNER.findall(data) for word in corner.split()[:3])
        except ValueError:
            raise NotSound("it has a corner that is no number") from None
    indices = {int(index) for index in set(_INDEX.findall(b"\n".join(_FACE.findall(data))))}
    if 0 in indices or (indices and not -corners <= min(indices) <= max(indices) <= corners):
        raise NotSound("it has a face of corners that are not there")


def _msh(data: bytes) -> None:
    counts = _MSH.unpack_from(data) if len(data) >= _MSH.size else (0, 0, 0, 0)
    corners, normals, points, faces = counts
    sizes = sum(count * size for count, size in zip(counts, (12, 12, 8, 12), strict=True))
    if min(counts) < 0 or len(data) != _MSH.size + sizes or {normals, points} - {0, corners}:
        raise NotSound("the MSH is damaged")
    numbers, indices = array("f", data[16 : 16 + 12 * corners]), array("i", data[len(data) - 12 * faces :])
    if byteorder == "big":
        numbers.byteswap()
        indices.byteswap()
    _check_near(numbers)
    _check_enough(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True))
    if faces and not 0 <= min(indices) <= max(indices) < corners:
        raise NotSound("it has a face of corners that are not there")


def _check_near(numbers: Iterable[float]) -> None:
    for number in numbers:
        if not -FARTHEST <= number <= FARTHEST:
            which = "is no finite number" if number != number or number in (_ENDLESS, -_ENDLESS) else f"is {number:g}"
            raise NotSound(f"a coordinate of a corner {which}")


_ENDLESS = float("inf")


def _check_enough(corners: Iterable[object]) -> None:
    different = set[object]()
    for corner in corners:
        different.add(corner)
        if len(different) == FEWEST:
            return
    what = f"MuJoCo takes {FEWEST} corners or more, and of this one only {len(different)} differ"
    raise NotSound(what, "name a mesh that has a surface")


def _png(data: bytes) -> None:
    if not _is_png(data):
        raise NotSound("it is no PNG that is whole", "export it anew, as PNG")


def _is_png(data: bytes) -> bool:
    """Say whether an image is a PNG from its first piece to its last; each says its length, and a sum of its bytes."""
    if not data.startswith(_PNG):
        return False
    start, kind = len(_PNG), b""
    while start + 12 <= len(data) and kind != b"IEND":
        (length,) = struct.unpack_from(">I", data, start)
        end = start + 8 + length
        kind = data[start + 4 : start + 8]
        if data[end : end + 4] != struct.pack(">I", zlib.crc32(data[start + 4 : end])):
            return False
        start = end + 4
    return kind == b"IEND"


_CHECKS: Mapping[str, Callable[[bytes], None]] = {".stl": _stl, ".obj": _obj, ".msh": _msh, ".png": _png}
