"""The package of docs/from-xacro.md, and what calls xacro and the compiler as ROS does: launch's Command, a prefix."""

import os
import shlex
import subprocess
import sys
from pathlib import Path

from support.pages import blocks
from support.paths import DOCS

PAGE = DOCS / "from-xacro.md"

# What ament_index_python does, by AMENT_PREFIX_PATH (ament/ament_index, packages.py).
_AMENT = """\
import os

class PackageNotFoundError(KeyError):
    pass

def get_package_share_directory(name):
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and os.path.isfile(f"{prefix}/share/ament_index/resource_index/packages/{name}"):
            return f"{prefix}/share/{name}"
    raise PackageNotFoundError(name)
"""


def package(folder: Path) -> Path:
    """Write the package of the page, as it is before its launch file changes; return its folder."""
    for block in blocks(PAGE.read_text("utf-8")):
        kind, name = block.mark
        if kind == "file":
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("\n".join(block.lines) + "\n", "utf-8")
    return folder


class Machine:
    """A computer with xacro and the compiler installed as programs, and ROS packages in prefixes."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        python = folder / "python" / "ament_index_python"
        python.mkdir(parents=True)
        (python / "__init__.py").write_text("", "utf-8")
        (python / "packages.py").write_text(_AMENT, "utf-8")
        (folder / "bin").mkdir()
        for program, call in (("xacro", "xacro"), ("rosorin-compile", "rosorin_compile.cli.main")):
            script = folder / "bin" / program
            text = f"#!{sys.executable}\nimport sys\nfrom {call} import main\nsys.exit(main())\n"
            script.write_text(text, "utf-8")
            script.chmod(0o755)
        self.environment = {
            **os.environ,
            "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": os.pathsep.join([str(folder / "python"), *sys.path]),
            "ROSORIN_COMPILE_CACHE": str(folder / "cache"),
            "AMENT_PREFIX_PATH": "",
            "ROS_PACKAGE_PATH": "",
        }

    def install(self, source: Path, name: str = "") -> Path:
        """Install a package into a prefix of its own, and source it; return its share folder."""
        name = name or source.name
        prefix = self.folder / "install" / name
        share = prefix / "share" / name
        share.parent.mkdir(parents=True)
        share.symlink_to(source, target_is_directory=True)
        index = prefix / "share" / "ament_index" / "resource_index" / "packages"
        index.mkdir(parents=True)
        (index / name).write_text("", "utf-8")
        before = self.environment["AMENT_PREFIX_PATH"]
        self.environment["AMENT_PREFIX_PATH"] = os.pathsep.join(filter(None, [str(prefix), before]))
        return share

    def run(self, *words: str, given: str = "") -> subprocess.CompletedProcess[str]:
        """Run a program to its end."""
        return subprocess.run(
            list(words), env=self.environment, cwd=self.folder, check=False, capture_output=True, text=True, input=given
        )

    def shell(self, line: str) -> subprocess.CompletedProcess[str]:
        """Run a line as a person types it into bash."""
        return self.run("bash", "-o", "pipefail", "-c", line)

    def command(self, *pieces: str) -> str:
        """Return what launch's Command returns: the pieces joined, split by shlex, run without a shell.

        By default (``on_stderr='fail'``) anything on standard error is a failure, as an exit code is.
        Sources: ros2/launch, launch/substitutions/command.py, on Humble and Jazzy.
        """
        ran = self.run(*shlex.split("".join(pieces)))
        if ran.returncode != 0 or ran.stderr:
            raise CommandFailed(f"exit code {ran.returncode}: {ran.stderr}")
        return ran.stdout


class CommandFailed(Exception):
    """launch gives up: SubstitutionFailure."""
