"""How long a height map of a mesh with 1,000,000 triangles takes, against trimesh merely loading the file.

In pairs in one process: ``trimesh.load(FILE)`` as everybody calls it, then the height map at 1 cm of the triangles that
are in memory; and the whole of ours, reading the file included. The mesh is a wavy plate of 0.3 x 0.23 m in a binary
STL. The rows below it show what larger triangles cost, that need more samples each, and ``--exact``. Last, whole
processes. Run with the environment's Python: ``python benchmarks/heightmap.py [PAIRS]``.
"""

from __future__ import annotations

import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import trimesh

from pairs import compare, row, wall_time
from rosorin_compile.importing.extract.height_map import Grid, surface_heights
from rosorin_compile.model.mesh_triangles import load_mesh

GRID = Grid((0.0, 0.0), 0.01, (30, 23))
BIN = Path(sys.executable).parent


def main(pairs: int) -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        path = Path(name, "plate.stl")
        write_stl(path, plate(1000, 500))
        mesh, large = load_mesh(path).triangles, needles(1_000_000, 0.01)
        head = "1,000,000 triangles, 30 x 23 cells of 1 cm"
        print(f"{head:<42} {'ours':>11} {'load':>11}   ratio, median of {pairs} pairs")
        load = partial(timed, partial(trimesh.load, path))
        bare = partial(timed, partial(trimesh.load, path, process=False))
        ours = partial(timed, partial(surface_heights, mesh, GRID))
        ratio = compare(ours, load, pairs)
        rate = len(mesh) / ratio.first / 1e6
        print(f"{row('height map / trimesh.load', ratio, 1.0)}   {rate:.1f} million triangles/s")
        for case, first, second, goal in (
            ("reading and height map / trimesh.load", partial(timed, partial(whole, path)), load, 2.0),
            ("height map / trimesh.load(process=False)", ours, bare, 1.0),
            ("small triangles / trimesh.load", partial(timed, partial(surface_heights, large, GRID)), load, 1.0),
            ("whole processes", partial(wall_time, command(path)), partial(wall_time, loading(path)), 2.0),
        ):
            print(row(case, compare(first, second, pairs), goal))


def command(path: Path) -> list[str]:
    """Return the whole command."""
    return [str(BIN / "rosorin-compile"), "extract", "heightmap", str(path), "--cell", "1cm", "--format", "json"]


def loading(path: Path) -> list[str]:
    """Return a process that loads a mesh."""
    return [sys.executable, "-c", f"import trimesh; trimesh.load({str(path)!r})"]


def timed(function: partial[object]) -> float:
    """Return the wall seconds of one call."""
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def whole(path: Path) -> None:
    """Read a mesh and make its height map."""
    surface_heights(load_mesh(path).triangles, GRID)


def plate(nx: int, ny: int) -> np.ndarray:
    """Return the triangles (2 * nx * ny, 3, 3) of a wavy surface over the grid."""
    x, y = np.meshgrid(np.linspace(0, 0.3, nx + 1), np.linspace(0, 0.23, ny + 1), indexing="ij")
    points = np.stack([x, y, 0.1 + 0.05 * np.sin(20 * x) * np.cos(30 * y)], axis=-1)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.concatenate([np.stack(corners, axis=-2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])


def needles(count: int, longest: float) -> np.ndarray:
    """Return triangles (count, 3, 3) anywhere over the grid, with edges up to a length."""
    generator = np.random.default_rng(1)
    middle = generator.uniform((0, 0, 0.05), (0.3, 0.23, 0.2), (count, 1, 3))
    return middle + generator.uniform(-longest / 4, longest / 4, (count, 3, 3))


def write_stl(path: Path, triangles: np.ndarray) -> None:
    """Write a binary STL."""
    records = np.zeros(len(triangles), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    records["corners"] = triangles
    path.write_bytes(bytes(80) + np.uint32(len(triangles)).tobytes() + records.tobytes())


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
