"""rosorin-compile bazel-dir: print the folder of the Bazel rule that ships with the tool."""

from __future__ import annotations

import argparse

from rosorin_compile.source.project import data_folder

from .usage import FINE


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes: nothing."""
    more = "rosorin_robot.bzl defines the rule; see docs/builds.md."
    command.description = f"{command.description} {more}"


def run(_: argparse.Namespace) -> int:
    """Print the folder that has rosorin_robot.bzl."""
    print(data_folder("bazel"))
    return FINE
