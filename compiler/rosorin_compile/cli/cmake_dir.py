"""rosorin-compile cmake-dir: print the folder of the CMake package that ships with the tool."""

from __future__ import annotations

from rosorin_compile.source.project import data_folder

from .command import Options, command
from .usage import FINE


@command(
    "cmake-dir",
    exits="0 printed",
    more="Pass it to find_package(rosorin_compile) as rosorin_compile_DIR; see docs/builds.md.",
)
def run(_: Options) -> int:
    """Print the folder that has rosorin_compileConfig.cmake."""
    print(data_folder("cmake"))
    return FINE
