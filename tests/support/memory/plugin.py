"""A plug-in of the program: a module that imports another one, opens a file beside it, and asks for a variable."""

from __future__ import annotations

import importlib
import os
import random
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from unittest import mock

from rosorin_compile.world import Notes, listening, notes

MODULES = ("toy", "toy_help")
STANDARD = tuple(
    folder for folder in sys.path if folder.startswith(str(Path(os.__file__).parent)) and "-packages" not in folder
)
FILES = {
    "toy-1.dist-info/METADATA": "Name: toy\nVersion: 1\n",
    "toy-1.dist-info/entry_points.txt": "[rosorin_compile.rules]\ntoy = toy:made\n",
    "toy.py": """\
import os
from pathlib import Path

import toy_help

def made():
    try:
        data = Path(__file__).with_name("data").read_text()
    except OSError:
        data = "no data"
    return f"1 {toy_help.VALUE} {data} {os.environ.get('X')}"
""",
    "toy_help.py": "VALUE = 1\n",
    "data": "1",
}


def changed(chance: random.Random) -> tuple[str, str]:
    """Return a file of the plug-in by name, as it is or with another number in it."""
    name = chance.choice(sorted(FILES))
    return name, FILES[name].replace("1", chance.choice("123"))


@contextmanager
def process(site: str, variables: Mapping[str, str]) -> Iterator[None]:
    """Have for a while what a process has that has just begun, with packages in the folder ``site``."""
    with (
        mock.patch.object(sys, "path", [site, *STANDARD]),
        mock.patch.object(sys, "dont_write_bytecode", True),
        mock.patch.object(notes, "_heard", Notes()),
        mock.patch.object(listening, "_listening", []),
        mock.patch.dict(os.environ, variables),
    ):
        importlib.invalidate_caches()
        try:
            yield
        finally:
            for name in MODULES:
                sys.modules.pop(name, None)
