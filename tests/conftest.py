"""Fixtures that several folders use, and which tests are slow."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.commands import write_files
from support.robots import copy_of_rosorin


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, which is the current one and has the cache."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    return tmp_path


@pytest.fixture
def project(home: Path, request: pytest.FixtureRequest) -> Path:
    """The current folder, a project with the files that ``PROJECT`` of the test's module names."""
    write_files(home, request.module.PROJECT)
    return home


@pytest.fixture
def rosorin(home: Path) -> Path:
    """The current folder, a project with the description of the reference robot."""
    copy_of_rosorin(home)
    return home


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark as slow what tries many inputs; the rest of what is slow says so itself."""
    for item in items:
        if getattr(getattr(item, "obj", None), "is_hypothesis_test", False):
            item.add_marker(pytest.mark.slow)
