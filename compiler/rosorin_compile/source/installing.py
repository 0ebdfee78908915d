"""Look up installed packages without importing them, and build the pip command that installs an extra."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from . import files

NAME = "rosorin-compile"
_CHECKOUT = Path(__file__).absolute().parents[3]
_OF_EXTRA = re.compile(r"""(?:^|\band\s+)extra\s*==\s*["']([^"']+)["']\s*$""")


def pip_install(extra: str) -> str:
    """Return the command that installs the packages of an extra.

    No index serves this package, so the command names what the extra requires.
    """
    from importlib.metadata import PackageNotFoundError, requires

    words: list[str] = []
    try:
        for requirement in requires(NAME) or ():
            what, _, marker = requirement.partition(";")
            if (of := _OF_EXTRA.search(marker.strip())) and of[1] == extra:
                rest = marker.strip()[: of.start()].strip()  # of the marker, such as python_version
                words.append(f"{what.strip()}; {rest}" if rest else what.strip())
    except PackageNotFoundError:  # run from a checkout
        folder = _CHECKOUT if files.is_file(_CHECKOUT / "pyproject.toml") else Path("path/to", NAME)
        words = [f"{folder}[{extra}]"]
    return f"pip install {' '.join(map(shlex.quote, words))}"


def package_folders(name: str) -> list[str]:
    """Return the folders of an installed package, or the file of a module, without importing it."""
    from importlib.util import find_spec

    try:
        spec = find_spec(name)
    except (ImportError, ValueError, AttributeError):
        return []
    return [] if spec is None else list(spec.submodule_search_locations or ()) or [spec.origin or name]


def is_installed(name: str) -> bool:
    """Return True if a package or module can be imported, without importing it."""
    return bool(package_folders(name))
