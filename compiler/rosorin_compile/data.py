"""The data packages: the folders that ship with the tool."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

# The data packages, each a folder of the same name at the top of the project (parts_library is ``parts``).
DATA = ("parts_library", "schemas", "templates")


def data_folder(name: str) -> Path:
    """Return the folder of a data package: "templates", "schemas" or "parts_library"."""
    return Path(import_module(f".{name}", __package__).__path__[0])
