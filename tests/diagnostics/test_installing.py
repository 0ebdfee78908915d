"""What pip is told to install: what this installation came from, as pip wrote it down beside the package."""

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.source.installing import pip_install

METADATA = """Metadata-Version: 2.4
Name: rosorin-compile
Version: 9.9
Requires-Dist: jinja2>=3.1
Provides-Extra: simulate
Requires-Dist: mujoco>=4.0; python_version >= "3.11" and extra == "simulate"
Requires-Dist: numpy>=1.26; extra == 'simulate'
Provides-Extra: view
Requires-Dist: trimesh>=5; extra == "view"
"""
COMMIT = "0123456789abcdef0123456789abcdef01234567"


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "site packages"
    (folder / "rosorin_compile-9.9.dist-info").mkdir(parents=True)
    monkeypatch.syspath_prepend(str(folder))
    return folder / "rosorin_compile-9.9.dist-info"


def installed(site: Path, origin: Any = None) -> None:
    """Write what pip leaves of an installation: the metadata, and where it came from."""
    (site / "METADATA").write_text(METADATA, "utf-8")
    if origin is not None:
        (site / "direct_url.json").write_text(origin if isinstance(origin, str) else json.dumps(origin), "utf-8")


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    folder = tmp_path / "a clone"
    folder.mkdir()
    (folder / "pyproject.toml").touch()
    return folder


def words(extra: str = "simulate") -> list[str]:
    return shlex.split(pip_install(extra))


def test_a_clone_that_is_edited_is_installed_so_again(site: Path, clone: Path) -> None:
    installed(site, {"url": clone.as_uri(), "dir_info": {"editable": True}})
    assert words() == ["pip", "install", "-e", f"{clone}[simulate]"]


def test_a_clone(site: Path, clone: Path) -> None:
    installed(site, {"url": clone.as_uri(), "dir_info": {}})
    assert pip_install("simulate") == f"pip install '{clone}[simulate]'"


@pytest.mark.parametrize("name", ["rosorin_compile-9.9-py3-none-any.whl", "rosorin_compile-9.9.tar.gz"])
def test_a_file(site: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / name).touch()
    installed(site, {"url": (tmp_path / name).as_uri(), "archive_info": {"hash": "sha256=0"}})
    assert words("view") == ["pip", "install", f"{tmp_path / name}[view]"]


@pytest.mark.parametrize(
    ("origin", "said"),
    [
        (
            {"url": "https://example.invalid/r.git", "vcs_info": {"vcs": "git", "commit_id": COMMIT}},
            f"rosorin-compile[simulate] @ git+https://example.invalid/r.git@{COMMIT}",
        ),
        (
            {
                "url": "https://example.invalid/r.git",
                "vcs_info": {"vcs": "git", "commit_id": COMMIT},
                "subdirectory": "tools/compile",
            },
            f"rosorin-compile[simulate] @ git+https://example.invalid/r.git@{COMMIT}#subdirectory=tools/compile",
        ),
        (
            {"url": "https://example.invalid/r.whl", "archive_info": {}},
            "rosorin-compile[simulate] @ https://example.invalid/r.whl",
        ),
    ],
)
def test_an_address(site: Path, origin: dict[str, Any], said: str) -> None:
    installed(site, origin)
    assert words() == ["pip", "install", said]
