"""The parts of the build that pyproject.toml cannot describe.

These are the licence, the page for PyPI, archives that are equal to the byte, and the installation by colcon.
"""

import gzip
import io
import os
import re
import sys
import tarfile
from pathlib import Path
from typing import ClassVar

from setuptools import Command, __version__, setup
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

sys.path.insert(0, "compiler")
# Archives contain no build time and do not depend on the umask: the same tree gives the same bytes. Zip begins in 1980;
# wheel reads the variable, too (https://reproducible-builds.org/docs/source-date-epoch/).
EPOCH = os.environ.setdefault("SOURCE_DATE_EPOCH", "315532800")
os.umask(0o022)
# A package of ROS: the marker of the ament index, and its package.xml.
SHARED = {
    "share/ament_index/resource_index/packages": ["ament/resource/rosorin_compile"],
    "share/rosorin_compile": ["package.xml"],
}
for name in ("LICENSE", "NOTICE", *(file for files in SHARED.values() for file in files)):  # copied with their modes
    if Path(name).stat().st_mode & 0o777 != 0o644:
        Path(name).chmod(0o644)


class BuildPy(build_py):
    """Copies the packages, with nothing of the modes that files have here."""

    def run(self) -> None:
        super().run()
        for path in Path(self.build_lib).rglob("*.*"):
            if path.is_file():
                path.chmod(0o644)


class Sdist(sdist):
    """Writes the archive itself: sorted, of one time, of nobody."""

    def make_archive(
        self,
        base_name: str,
        format: str,
        root_dir: str | None = None,
        base_dir: str | None = None,
        *_: object,  # owner and group
        **__: object,
    ) -> str:
        if format != "gztar":
            raise ValueError(f"an sdist is a .tar.gz, not {format}")
        top = Path(root_dir or ".", base_dir or ".")
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
            for path in sorted((path for path in top.rglob("*") if path.is_file()), key=Path.as_posix):
                entry = tarfile.TarInfo(f"{top.name}/{path.relative_to(top).as_posix()}")
                entry.size, entry.mtime = path.stat().st_size, int(EPOCH)
                entry.mode = 0o755 if path.stat().st_mode & 0o100 else 0o644
                with path.open("rb") as file:
                    archive.addfile(entry, file)
        made = Path(f"{base_name}.tar.gz")
        made.write_bytes(gzip.compress(packed.getvalue(), mtime=0))
        return str(made)


class Develop(Command):
    """Replaces a command of setuptools that only ``colcon build --symlink-install`` uses.

    It cannot link folders such as templates/ into the package. Without the option --editable here, colcon installs
    copies instead. ``pip install -e`` does not need it.
    """

    user_options: ClassVar = []

    def initialize_options(self) -> None:
        """Do nothing: there are no options."""

    def finalize_options(self) -> None:
        """Do nothing: there are no options."""

    def run(self) -> None:
        raise SystemExit("not supported: use pip install -e .")


def page(text: str) -> str:
    """Return README.md for an index, which has no file that it names: without pictures and comments, links as words."""
    text = re.sub(r"<!--.*?-->\n?|<picture>.*?</picture>\n*", "", text, flags=re.DOTALL)
    text = re.sub(r"!\[[^\]]*\]\((?!https?:)[^)]*\)\n*", "", text)
    return re.sub(r"\[([^\]]*)\]\((?!https?:)[^)]*\)", r"\1", text)


def addresses() -> dict[str, str]:
    """Return where the project is, once a person has said so (RELEASING.md)."""
    from rosorin_compile.source.version import HOME

    return {"Homepage": HOME} if HOME else {}


# An expression, as pyproject.toml may have it since setuptools 77. Debian 12 has 66, which reads a table there; that is
# what newer ones stop taking.
LICENCE = "license_expression" if int(__version__.partition(".")[0]) >= 77 else "license"
setup(
    **{LICENCE: "Apache-2.0", "license_files": ["LICENSE", "NOTICE"]},
    python_requires=">=3.10",  # not in pyproject.toml: colcon cannot read the object that setuptools makes of that
    data_files=list(SHARED.items()),
    cmdclass={"build_py": BuildPy, "develop": Develop, "sdist": Sdist},
    long_description=page(Path("README.md").read_text("utf-8")),
    long_description_content_type="text/markdown",
    project_urls=addresses(),
)
