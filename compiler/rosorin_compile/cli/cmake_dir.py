"""rosorin-compile cmake-dir: print the folder of the CMake package that ships with the tool."""

from rosorin_compile.source.project import data_folder

from .command import Options, command

_MORE = "Pass it to find_package(rosorin_compile) as rosorin_compile_DIR; see docs/builds.md."


@command("cmake-dir", exits="0 printed", more=_MORE)
def run(options: Options) -> int:
    """Print the folder that has rosorin_compileConfig.cmake."""
    folder = str(data_folder("cmake"))
    return options.console.give(folder, lambda: folder)
