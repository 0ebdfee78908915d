"""rosorin-compile cmake-dir: print the folder of the CMake package that ships with the tool."""

from __future__ import annotations

import argparse

from rosorin_compile.source.project import data_folder

from .usage import FINE


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes: nothing."""
    more = "Pass it to find_package(rosorin_compile) as rosorin_compile_DIR"
    command.description = f"{command.description} {more}; see docs/builds.md."


def run(_: argparse.Namespace) -> int:
    """Print the folder that has rosorin_compileConfig.cmake."""
    print(data_folder("cmake"))
    return FINE
