"""Reading: one side of a comparison from whatever it was named as: a description, or a file of another format."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..diagnostic import ERROR, Diagnostic, has_errors
from ..emit import FORMATS, endings
from ..project import NoDescription, find
from .printing import printing_of
from .values import YAML, Side

# What a person is to know before a foreign file is opened.
_XACRO = "xacro-runs-code"
_TOLD = (_XACRO,)


class Read(NamedTuple):
    """One side (None if it could not be read), what there is to say, and what of the file is not part of it."""

    side: Side | None
    diagnostics: list[Diagnostic]
    left_out: tuple[str, ...] = ()

    @property
    def expanded(self) -> bool:
        """Whether the file is a xacro, which takes arguments."""
        return any(said.rule == _XACRO for said in self.diagnostics)


def read_side(word: str, arguments: Mapping[str, Any], packages: Mapping[str, Path]) -> Read:
    """Return the robot that a word names: file of any format, folder or name of a description.

    ``arguments`` are those of a description or a xacro file. Raises project.NoDescription if there is no such robot.
    """
    path = Path(word)
    if path.is_file() and path.suffix.lower() not in YAML.endings:
        return _foreign(path, word, arguments, packages)
    if path.suffix.lower() in endings():
        raise NoDescription(f'there is no file "{word}"')
    return _description(find([word], None)[0].path, word, arguments)


def _description(path: Path, word: str, arguments: Mapping[str, Any]) -> Read:
    from ..pipeline import understand

    _, built, diagnostics = understand(path, arguments)
    errors = [diagnostic for diagnostic in diagnostics if diagnostic.severity == ERROR]
    if errors or built is None or built.robot is None:
        return Read(None, errors)
    said = [diagnostic for diagnostic in diagnostics if diagnostic.rule in _TOLD]
    return Read(Side(word, YAML, built.robot, folder=path.parent), said)


def _foreign(path: Path, word: str, arguments: Mapping[str, Any], packages: Mapping[str, Path]) -> Read:
    from ..build import build
    from ..importing import ReadOptions, read_robot

    texts = {name: str(value) for name, value in arguments.items()}
    imported = read_robot(path, ReadOptions(texts, packages, lenient=True))
    said = [d for d in imported.diagnostics if d.severity == ERROR or d.rule in _TOLD]
    if imported.tree is None or has_errors(said):
        return Read(None, said)
    built = build(imported.tree)
    if built.robot is None:
        return Read(None, [*said, *built.diagnostics])
    side = Side(word, FORMATS[imported.format], built.robot, printing_of(imported.tree), path.parent)
    return Read(side, said, tuple(left.what for left in imported.left_out))
