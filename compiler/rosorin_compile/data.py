"""The data packages: the folders ``templates`` and ``schemas`` that ship with the tool."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path


def data_folder(name: str) -> Path:
    """Return the folder of a data package, "templates" or "schemas", wherever the tool is installed."""
    return Path(import_module(f".{name}", __package__).__path__[0])
