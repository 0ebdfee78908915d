"""Build the pip command that installs an extra, from the origin of this installation.

No index serves the package, so its name alone installs nothing. pip records the origin beside the package:
https://packaging.python.org/en/latest/specifications/direct-url/.
"""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from urllib.parse import urlsplit
from urllib.request import url2pathname

from . import files

NAME = "rosorin-compile"
_CHECKOUT = Path(__file__).absolute().parents[3]
_OF_EXTRA = re.compile(r"""(?:^|\band\s+)extra\s*==\s*["']([^"']+)["']\s*$""")


def pip_install(extra: str) -> str:
    """Return the command that installs an extra of this installation."""
    from importlib.metadata import PackageNotFoundError, distribution

    try:
        installed = distribution(NAME)
    except PackageNotFoundError:  # run from a checkout
        words = [f"{_CHECKOUT if _is_project(_CHECKOUT) else f'path/to/{NAME}'}[{extra}]"]
    else:
        words = _from_origin(installed.read_text("direct_url.json") or "{}", extra)
        for requirement in () if words else installed.requires or ():
            what, _, marker = requirement.partition(";")
            if (of := _OF_EXTRA.search(marker.strip())) and of[1] == extra:
                rest = marker.strip()[: of.start()].strip()  # of the marker, such as python_version
                words.append(f"{what.strip()}; {rest}" if rest else what.strip())
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


def _is_project(folder: Path) -> bool:
    return files.is_file(folder / "pyproject.toml")


def _from_origin(text: str, extra: str) -> list[str]:
    """Return the arguments of pip that install from an origin (direct_url.json), as long as that exists."""
    try:
        origin = json.loads(text)
        address = str(origin["url"])
    except (ValueError, KeyError, TypeError):  # from an index; or a file that pip did not write
        return []
    if about := origin.get("vcs_info"):
        folder = f"#subdirectory={origin['subdirectory']}" if origin.get("subdirectory") else ""
        return [f"{NAME}[{extra}] @ {about['vcs']}+{address}@{about['commit_id']}{folder}"]
    if not address.startswith("file:"):
        return [f"{NAME}[{extra}] @ {address}"]
    path, is_folder = Path(url2pathname(urlsplit(address).path)), "dir_info" in origin
    if not (_is_project(path) if is_folder else files.is_file(path)):
        return []
    return [*(["-e"] if is_folder and origin["dir_info"].get("editable") else []), f"{path}[{extra}]"]
