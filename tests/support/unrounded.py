"""Compiling with all digits of numbers, as an import does that is held against its source."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosorin_compile import CompileResult
from rosorin_compile.formats.compilation import compile_robot


def compile_unrounded(
    path: Path, arguments: Mapping[str, Any] | None = None, packages: Mapping[str, Path] | None = None
) -> CompileResult:
    """Compile a description; numbers are exact where an output does not say how it prints them."""
    return compile_robot(path, arguments, packages=packages, exact=True)
