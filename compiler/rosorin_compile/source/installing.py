"""Installing: the command of pip that brings what an extra has, from where this installation came.

No index serves the package, so that its name alone installs nothing. What pip wrote beside the package says what it was
made of: https://packaging.python.org/en/latest/specifications/direct-url/.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import files

if TYPE_CHECKING:
    from importlib.metadata import Distribution

NAME = "rosorin-compile"
_OF_EXTRA = re.compile(r"""(?:^|\band\s+)extra\s*==\s*["']([^"']+)["']\s*$""")


def pip_install(extra: str) -> str:
    """Return the command that installs an extra: what this installation came from with it, or its requirements."""
    return f"pip install {' '.join(shlex.quote(word) for word in _words(extra))}"


def package_folders(name: str) -> list[str]:
    """Return the folders of an installed package, which is not imported; of a module its file; nothing without one."""
    from importlib.util import find_spec

    try:
        spec = find_spec(name)
    except (ImportError, ValueError, AttributeError):
        return []
    return [] if spec is None else list(spec.submodule_search_locations or ()) or [spec.origin or name]


def is_installed(name: str) -> bool:
    """Whether a package or module can be imported, by its name; it is not imported."""
    return bool(package_folders(name))


def _words(extra: str) -> Sequence[str]:
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        installed = distribution(NAME)
    except PackageNotFoundError:  # run from a tree of sources
        return _of_folder(_sources(), extra) or [f"path/to/{NAME}[{extra}]"]
    return _of_origin(installed, extra) or _required(installed.requires or [], extra)


def _sources() -> Path:
    """Return the root of the clone that has this file, if it is one."""
    return Path(__file__).absolute().parents[3]


def _of_origin(installed: Distribution, extra: str) -> Sequence[str]:
    """Return what installs from where a distribution came, as long as that is there."""
    import json

    try:
        origin = json.loads(installed.read_text("direct_url.json") or "{}")
        address = str(origin["url"])
    except (ValueError, KeyError, TypeError):  # from an index; or a file that pip did not write
        return []
    if "vcs_info" in origin:
        return [f"{NAME}[{extra}] @ {_of_version_control(address, origin)}"]
    if not address.startswith("file:"):
        return [f"{NAME}[{extra}] @ {address}"]
    path = _path(address)
    if "dir_info" not in origin:
        return [f"{path}[{extra}]"] if files.is_file(path) else []
    return _of_folder(path, extra, bool(origin["dir_info"].get("editable")))


def _path(address: str) -> Path:
    from urllib.parse import urlsplit
    from urllib.request import url2pathname

    return Path(url2pathname(urlsplit(address).path))


def _of_folder(folder: Path, extra: str, editable: bool = False) -> Sequence[str]:
    if not files.is_file(folder / "pyproject.toml"):
        return []
    return [*(["-e"] if editable else []), f"{folder}[{extra}]"]


def _of_version_control(address: str, origin: dict[str, Any]) -> str:
    about = origin["vcs_info"]
    folder = origin.get("subdirectory")
    return f"{about['vcs']}+{address}@{about['commit_id']}" + (f"#subdirectory={folder}" if folder else "")


def _required(requirements: Sequence[str], extra: str) -> Sequence[str]:
    """Return the requirements of an extra, with what is left of their markers.

    >>> _required(["numpy>=1.26; extra == 'view'", 'mujoco; python_version >= "3.11" and extra == "view"'], "view")
    ['numpy>=1.26', 'mujoco; python_version >= "3.11"']
    """
    found = []
    for requirement in requirements:
        what, _, marker = requirement.partition(";")
        marker = marker.strip()
        of = _OF_EXTRA.search(marker)
        if of and of[1] == extra:
            left = marker[: of.start()].strip()
            found.append(f"{what.strip()}; {left}" if left else what.strip())
    return found
