"""Real runs of the real command in a small project: what the kernel was asked, and what was noted."""

from __future__ import annotations

import json
import marshal
import os
import re
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

ROBOT = """\
robot: r
include: [arm.yaml, {file: claw.xacro, parent: tip, trust: true}]
args: {width: {type: length, default: 1 m}}
links: {base_link: {visual: [{mesh: {file: meshes/a.stl}}], collision: [{sphere: {radius: "${width}"}}]}}
outputs:
  urdf: {file: r.urdf}
  mjcf: {file: r.xml}
  mine: {file: m.txt, backend: template, template: t.jinja}
"""
ARM = """\
links: {tip: {collision: [{mesh: {file: "package://vend/b.stl"}}]}}
joints: {j: {type: fixed, parent: base_link, child: tip}}
"""
CLAW = """\
<robot name="claw" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="more.xacro"/>
<link name="claw_$(optenv SIDE left)"/></robot>
"""
MORE = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="x" value="1"/></robot>\n'

_CALL = re.compile(r"(\d+) +(\w+)\((.*)")
_HERE = re.compile(r"AT_FDCWD<([^>]*)>")
_PATH = re.compile(r'"((?:[^"\\]|\\.)*)"')


class Project:
    """A project in a folder, with a home, a workspace of packages and a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "project"
        self.cache = folder / "cache"
        self.vendor = folder / "ws" / "vend"
        self.log = folder / "log"
        home = self.folder / "descriptions" / "r"
        for place in (home / "meshes", self.vendor, folder / "home"):
            place.mkdir(parents=True)
        for name, text in {"robot.yaml": ROBOT, "arm.yaml": ARM, "claw.xacro": CLAW, "more.xacro": MORE}.items():
            (home / name).write_text(text, "utf-8")
        (self.folder / "fleet.csv").write_text("name,width\none,1 m\ntwo,2 m\n", "utf-8")
        (home / "t.jinja").write_text("{{ robot.name }}\n", "utf-8")
        (home / "meshes" / "a.stl").write_bytes(_stl(1.0))
        (self.vendor / "package.xml").write_text("<package><name>vend</name></package>\n", "utf-8")
        (self.vendor / "b.stl").write_bytes(_stl(2.0))
        self.tops = (str(self.folder), str(self.vendor.parent), str(folder / "home"))
        self.environment = {**os.environ, "HOME": str(folder / "home"), "ROS_PACKAGE_PATH": str(self.vendor.parent)}
        self.environment["ROSORIN_COMPILE_CACHE"] = str(self.cache)

    def run(self, *words: str, memory: bool = True, traced: bool = False) -> tuple[int, str, str]:
        """Run a command line; return its exit code and what it says on both streams."""
        command = [sys.executable, "-m", "rosorin_compile", *words]
        if traced:
            command = ["strace", "-f", "-qq", "-y", "-s", "4096", "-e", "trace=%file", "-o", str(self.log), *command]
        environment = dict(self.environment)
        if not memory:
            environment["ROSORIN_COMPILE_CACHE"] = "off"
        done = subprocess.run(command, cwd=self.folder, env=environment, capture_output=True, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    def records(self) -> dict[str, tuple[int, int]]:
        """Return what tells the records that are kept from others: a run that is made keeps its own anew."""
        return {one.name: (one.stat().st_ino, one.stat().st_mtime_ns) for one in (self.cache / "runs").iterdir()}

    def asked(self) -> list[str]:
        """Return the paths below the project, the home and the packages that the kernel was asked for to read."""
        found: dict[str, None] = {}
        folders: dict[str, str] = {}  # of processes that went elsewhere
        for line in self.log.read_text("utf-8", "surrogateescape").splitlines():
            call = _CALL.match(line)
            paths = _PATH.findall(call[3]) if call else []
            if call is None or not paths:
                continue
            here = _HERE.search(call[3])
            whole = os.path.normpath(Path(here[1] if here else folders.get(call[1], str(self.folder)), paths[0]))
            if call[2] == "chdir":
                folders[call[1]] = whole
            elif call[2] in _WRITING or any(sign in line for sign in ("O_WRONLY", "O_RDWR", "O_CREAT")):
                continue
            elif any(whole.startswith(top + os.sep) for top in self.tops):
                found[whole] = None
        return list(found)

    def noted(self) -> set[str]:
        """Return the paths that the records of all runs have, with the folders that lead there."""
        found: set[str] = set()
        for record in (self.cache / "runs").iterdir():
            answers = marshal.loads(record.read_bytes().partition(b"\n")[2])[1]  # noqa: S302 - our own
            found |= self._paths(question for question, _ in answers)
        return found

    def noted_of_sweep(self, out: str) -> set[str]:
        """Return the same of what the variants in a folder were made of."""
        found: set[str] = set()
        for made_of in (self.folder / out / ".rosorin-compile-sweep" / "made_of").iterdir():
            rows = json.loads(made_of.read_bytes())["asked"]
            found |= self._paths((kind, subject) for kind, subject, _ in rows)
        return found

    def _paths(self, questions: Iterable[tuple[str, str]]) -> set[str]:
        found: set[str] = set()
        for kind, subject in questions:
            if kind == "tool":  # under -m the folder that one stands in is one that Python imports from
                found |= {str(inside / "__init__.py") for inside in self.folder.iterdir()}
            for path in subject.split("\0"):
                whole = Path(os.path.normpath(self.folder / path))
                found |= {str(whole), *map(str, whole.parents)}
        return found

    def variants(self, out: str) -> dict[str, bytes]:
        """Return the files of the variants in a folder, and their index."""
        top = self.folder / out
        files = [path for path in top.rglob("*") if path.is_file() and ".rosorin-compile-sweep" not in path.parts]
        return {path.relative_to(top).as_posix(): path.read_bytes() for path in files}


_WRITING = ("mkdir", "mkdirat", "rename", "renameat", "renameat2", "unlink", "unlinkat", "rmdir", "chmod", "fchmodat")
_WRITING += ("utimensat", "link", "linkat", "symlink", "symlinkat", "execve", "chdir", "getcwd", "statfs")


def _stl(size: float) -> bytes:
    import struct

    corners = ((0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size))
    faces = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for at in face for v in corners[at]), 0) for face in faces)
    return b"a".ljust(80) + struct.pack("<I", 4) + rows
