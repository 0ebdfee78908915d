"""The commands ``check``, ``write`` (``all``), ``explain`` and ``schema`` for programs: values in, values out.

``compile`` and ``read`` stand in ``pipeline``, ``diff`` in ``sides``. Nothing is printed, and what is wrong with a
robot's files is no exception: it is among the diagnostics.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import Diagnostic, has_errors
from rosorin_compile.source.project import Description

from .given import Given
from .registry import service

if TYPE_CHECKING:
    from distributed import Client

    from rosorin_compile.language.explain.explanation import Answer, Explanation
    from rosorin_compile.output.pipeline import Compiled, Understood

    Name = str | os.PathLike[str]


@dataclass(frozen=True)
class Checked:
    """Whether the committed artifacts of a robot are those of its description.

    ``differing`` are the files that are not as compiled (missing, changed, or no artifact any more); ``lines`` says
    how they differ, as the command line does. Both are empty where ``compiled`` has errors.
    """

    compiled: Compiled
    folder: Path
    differing: tuple[str, ...]
    lines: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def same(self) -> bool:
        """Whether the robot has no errors, no engine refuses an artifact, and each is as committed."""
        return not self.differing and not has_errors(self.diagnostics)

    def __str__(self) -> str:
        """Return what differs, in lines."""
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Written:
    """What writing the artifacts of a robot into ``folder`` did to each file there, by name.

    ``kept`` are no artifacts and were left alone, ``removed`` were none either and are gone because pruning was asked
    for. With errors among the diagnostics nothing is written.
    """

    compiled: Compiled
    folder: Path
    written: tuple[str, ...]
    unchanged: tuple[str, ...]
    kept: tuple[str, ...]
    removed: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]


@dataclass(frozen=True)
class Explained:
    """Where things of a robot sit, and where each of their numbers was written; none if the robot has errors."""

    answers: tuple[Explanation | Answer, ...]
    diagnostics: tuple[Diagnostic, ...]

    @classmethod
    def of(cls, found: Understood, arguments: Mapping[str, Any], names: Sequence[str], pose: str = "") -> Explained:
        """Return the same of a description without errors that was read with these arguments. Raises KeyError."""
        from rosorin_compile.language.explain.answer import NotThere, explain

        if found.lowered is None:
            raise ValueError("a description with errors has no meaning to explain")
        try:
            answers = explain(found.expanded, found.lowered, arguments, names, pose)
        except NotThere as problem:
            raise KeyError(str(problem)) from None
        return cls(tuple(answers), tuple(found.diagnostics))

    def lines(self) -> list[str]:
        """Return what the command line prints, line by line."""
        from .explain_text import lines

        return [line for answer in self.answers for line in lines(answer)]

    def __str__(self) -> str:
        """Return what the command line prints."""
        return "\n".join(self.lines())


def check(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
) -> Checked:
    """Compile a description and compare with its committed artifacts, as ``rosorin-compile check`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``. ``outputs`` is the folder that has a folder a robot; by
    default that of the project.
    """
    from .comparing import compared

    description, given, compiled = _proven(path, arguments, packages, outputs)
    said = compiled.diagnostics
    if description is None or compiled.robot is None or has_errors(said):
        return Checked(compiled, _folder(description), (), (), tuple(said))
    held = compared(given, description, compiled)
    return Checked(compiled, description.outputs, held.differing(), tuple(held.lines()), (*said, *held.diagnostics))


def write(
    path: Name,
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    outputs: Name | None = None,
    prune: bool = False,
) -> Written:
    """Compile a description and write its artifacts, the whole set or nothing, as ``rosorin-compile all`` does.

    ``path``, ``arguments`` and ``packages`` as in ``compile``, ``outputs`` as in ``check``. ``prune`` removes what is
    no artifact from the robot's folder.
    """
    from rosorin_compile.output import OutputError, write_artifacts

    from .all import left_alone

    description, _, compiled = _proven(path, arguments, packages, outputs)
    said, folder = compiled.diagnostics, _folder(description)
    if not compiled.artifacts or has_errors(said):
        return Written(compiled, folder, (), (), (), (), tuple(said))
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    try:
        done = write_artifacts(folder, {**compiled.mesh_files, **files}, prune)
    except OutputError as problem:
        return Written(compiled, folder, (), (), (), (), (*said, problem.diagnostic))
    more = (*done.diagnostics(folder), *left_alone(folder, done))
    return Written(compiled, folder, done.written, done.unchanged, done.kept, done.removed, (*said, *more))


def explain(
    path: Name,
    names: Sequence[str],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, Name] | None = None,
    pose: str = "",
) -> Explained:
    """Return where frames, links, joints, sensors and uses of parts sit, and where each number of theirs was written.

    ``path``, ``arguments`` and ``packages`` as in ``compile``; ``names`` and ``pose`` as ``rosorin-compile explain``
    takes them. Raises KeyError for a name that the robot does not have, with what is near.
    """
    from rosorin_compile.output.pipeline import understand

    description, given, wrong = Given.asked(path, arguments, packages)
    if description is None:
        return Explained((), tuple(wrong))
    values = given.values()
    found = understand(description.path, values, packages=given.packages)
    if found.lowered is None or found.lowered.robot is None or has_errors(found.diagnostics):
        return Explained((), tuple(found.diagnostics))
    return Explained.of(found, values, names, pose)


def sweep(
    path: str | os.PathLike[str],
    variants: str | os.PathLike[str] | Mapping[str, Any] | Iterable[Any],
    arguments: Mapping[str, Any] | None = None,
    packages: Mapping[str, str | os.PathLike[str]] | None = None,
    client: Client | None = None,
) -> Iterator[Compiled]:
    """Yield what becomes of a description with the arguments of each variant; nothing is written.

    ``variants`` is what ``rosorin-compile sweep --over`` takes, a CSV or YAML file or a folder; or arguments by name;
    or pairs of a name and arguments, or tables with ``name`` among the arguments, also from a generator. ``arguments``
    hold for all, where a variant has none of its own; they and ``packages`` are those of ``compile``. Each ``Compiled``
    has its ``variant``. With ``client``, a ``distributed.Client``, they are compiled on its cluster; OutputError is
    raised if that fails. The order is that of ``variants``.

    What is wrong with a variant is among its diagnostics; what is wrong with all, such as the list itself, is a single
    ``Compiled`` without a variant.
    """
    made: Iterator[Compiled] = service("many variants")(path, variants, arguments, packages, client)
    return made


def schema(name: str = "authoring") -> dict[str, Any]:
    """Return a JSON Schema by a name of ``rosorin-compile schema``. Raises KeyError, with what is near."""
    import json

    from rosorin_compile.source.diagnostics import did_you_mean

    from .schema import names, text_of

    if name not in (known := names()):
        raise KeyError(f'there is no schema "{name}"; {did_you_mean(name, known)}')
    found: dict[str, Any] = json.loads(text_of(name))
    return found


def _proven(
    path: Name, arguments: object, packages: object, outputs: Name | None
) -> tuple[Description | None, Given, Compiled]:
    """Return what becomes of a description with its meshes, read back as a command does before it writes."""
    from rosorin_compile.output.pipeline import Compiled, compile_robot

    from .compiling import search_meshes

    description, given, wrong = Given.asked(path, arguments, packages, outputs)
    if description is None:
        return None, given, Compiled(None, (), wrong, ())
    search = partial(search_meshes, given, description)
    return (
        description,
        given,
        compile_robot(description.path, given.values(), packages=given.packages, search=search).proven(),
    )


def _folder(description: Description | None) -> Path:
    return description.outputs if description is not None else Path()
