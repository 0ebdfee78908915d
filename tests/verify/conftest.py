"""Recordings that several modules read; none of them changes one."""

from pathlib import Path

import pytest

from support import bags


@pytest.fixture(scope="session")
def clean(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a short clean recording in both storages."""
    folder = tmp_path_factory.mktemp("clean")
    return {storage: bags.bag(folder / storage, storage, seconds=3.0) for storage in ("sqlite3", "mcap")}
