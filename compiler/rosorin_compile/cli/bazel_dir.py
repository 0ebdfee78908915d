"""rosorin-compile bazel-dir: print the folder of the Bazel rule that ships with the tool."""

from __future__ import annotations

from rosorin_compile.source.project import data_folder

from .answer import give_result
from .command import Options, command
from .usage import FINE


@command("bazel-dir", exits="0 printed", more="rosorin_robot.bzl defines the rule; see docs/builds.md.")
def run(options: Options) -> int:
    """Print the folder that has rosorin_robot.bzl."""
    folder = data_folder("bazel")
    give_result(options, str(folder), lambda: str(folder))
    return FINE
