"""The pip command that installs an extra."""

from __future__ import annotations

import shlex
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from rosorin_compile.source.system import pip_install

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


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of packages that Python asks first."""
    folder = tmp_path / "site packages"
    (folder / "rosorin_compile-9.9.dist-info").mkdir(parents=True)
    monkeypatch.syspath_prepend(str(folder))
    return folder / "rosorin_compile-9.9.dist-info"


def words(extra: str = "simulate") -> list[str]:
    return shlex.split(pip_install(extra))


def test_the_requirements_of_an_extra(site: Path) -> None:
    (site / "METADATA").write_text(METADATA, "utf-8")
    assert words() == ["pip", "install", 'mujoco>=4.0; python_version >= "3.11"', "numpy>=1.26"]
    assert words("view") == ["pip", "install", "trimesh>=5"]


def test_a_tree_that_nobody_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    def requires(name: str) -> list[str]:
        raise PackageNotFoundError(name)

    monkeypatch.setattr("importlib.metadata.requires", requires)
    assert words() == ["pip", "install", "path/to/rosorin-compile[simulate]"]
