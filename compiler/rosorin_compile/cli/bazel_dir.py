"""rosorin-compile bazel-dir: print the folder of the Bazel rule that ships with the tool."""

from rosorin_compile.source.project import data_folder

from .command import Options, command


@command("bazel-dir", exits="0 printed", more="rosorin_robot.bzl defines the rule; see docs/builds.md.")
def run(options: Options) -> int:
    """Print the folder that has rosorin_robot.bzl."""
    folder = str(data_folder("bazel"))
    return options.console.give(folder, lambda: folder)
