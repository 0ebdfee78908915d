"""Compile the description of an imported robot in a temporary folder, and compare it with the source."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rosorin_compile.compare.artifacts import agreement
from rosorin_compile.compare.describe import Describer
from rosorin_compile.compare.precision import NOISE, Precision
from rosorin_compile.compare.walk import compare_leaves, leaves
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import CompileResult, compile_robot
from rosorin_compile.formats.gazebo import element_differences, followers_of
from rosorin_compile.formats.imported_robot import ImportedRobot, Outputs, Proof
from rosorin_compile.formats.robot_files import outputs_of
from rosorin_compile.model import Robot
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Related, Source, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.tree import Map
from rosorin_compile.source.wording import and_more, count_of, phrase

from .description import write
from .elements.sections import without_collisions
from .mesh_names import seen_from
from .repeats.parts import with_parts

_MAX_DIFFERENCES = 20


class RoundTrip(NamedTuple):
    """The files of a description by name, and the comparison of the compiled description with the source."""

    files: dict[str, str]
    outputs: Outputs  # the section ``outputs``: artifacts to compile
    diagnostics: list[Diagnostic]  # compile errors, or differences from the source
    shown: ImportedRobot  # the robot in ``files``, possibly with parts
    proof: Proof = Proof()  # comparison in a simulator, such as MuJoCo for an MJCF
    untold: tuple[Diagnostic, ...] = ()  # errors for differences that only the simulator shows
    reordered: bool = False  # True if the order of moving joints differs from the source


def check_round_trip(
    imported: ImportedRobot,
    folder: Path,
    parts: bool = True,
    plain: Map | None = None,
    packages: Mapping[str, Path] = MappingProxyType({}),
) -> RoundTrip:
    """Write the description of a robot to a temporary folder, compile it, and compare the result with the source.

    Meshes are looked up relative to ``folder``, the final folder of the description, and in ``packages``. ``plain`` is
    the robot before Gazebo and ros2_control elements were converted, or None if no element was converted. If ``parts``
    is True, repeated structures become parts, unless this would change the robot.
    """
    shown = with_parts(imported) if parts else imported
    if shown is not imported:
        trip = _round_trip(imported, shown, folder, plain, packages)
        # Do not reorder the joints of an MJCF, because MuJoCo controllers address joints by index.
        if not (trip.diagnostics or trip.untold or (trip.reordered and imported.format == "mjcf")):
            return trip
    return _round_trip(imported, imported, folder, plain, packages)


def _round_trip(
    imported: ImportedRobot, shown: ImportedRobot, folder: Path, plain: Map | None, packages: Mapping[str, Path]
) -> RoundTrip:
    Progress.step("proving the import")
    outputs = outputs_of(imported)
    for _ in range(2):
        texts = write(shown, outputs, schema_path(folder))
        compiled = _compile(texts, imported.packages, exact=True)
        trip = RoundTrip(texts, outputs, [], shown)
        errors = [one for one in compiled.diagnostics if one.severity == ERROR]
        if not errors:
            break
        # Usually only the MJCF needs data that the source lacks, such as a mass: retry without the MJCF.
        outputs = outputs_of(imported, " ".join(errors[0].message.split()))
    for one in errors:
        if one.span is not None:  # report the final folder instead of the temporary folder
            source = Source(str(folder / Path(one.span.source.path).name), one.span.source.text)
            one = replace(one, span=one.span._replace(source=source), related=())
        trip.diagnostics.append(one)
    if errors:
        return trip
    before, made = imported._replace(tree=plain or imported.whole).robot, compiled.robot
    if before is None or made is None:
        return trip._replace(diagnostics=[_differs("the description cannot be compared with the source", [])])
    found = [] if plain is None else _element_changes(before, made)
    if plain is not None:  # skip converted elements, because they were already compared as XML
        names = ("urdf_elements", "sensors", "edges", "publishers", "control")
        made_plain = replace(made, **{name: getattr(before, name) for name in names})
    found += model_differences(before, made if plain is None else made_plain, 0.0)
    diagnostics = [_differs("the description would not be the same robot", found)] if found else []
    diagnostics += agreement(made, compiled.artifacts)
    moving = [[joint.name for joint in robot.joints if not joint.is_fixed] for robot in (before, made)]
    trip = trip._replace(diagnostics=diagnostics, reordered=moving[0] != moving[1])
    if diagnostics:
        return trip
    proof = _proof(imported, shown, outputs, folder, packages)
    if not proof.wrong:
        return trip._replace(proof=proof)
    count = len(proof.texts)
    what = f"{count_of(count, 'thing')} {'comes' if count == 1 else 'come'} out otherwise than in the source"
    message = f"{what}, and nothing above says so: {phrase(list(proof.wrong))}"
    help = "please report it with the file; --lenient writes it all the same"
    untold = Diagnostic("import-untold", ERROR, message, None, _some(proof.texts), help)
    return trip._replace(proof=proof, untold=(untold,))


def schema_path(folder: Path) -> str:
    """Return the path of the JSON schema for editors relative to a folder, or "" if the project has no schema."""
    schema = Description.SCHEMA
    return (Path("..") / schema).as_posix() if files.is_file(folder.parent / schema) else ""


def _compile(texts: Mapping[str, str], packages: Mapping[str, Path], **options: Any) -> CompileResult:
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as stage:
        for name, text in texts.items():
            Path(stage, name).write_text(text, "utf-8")
        return compile_robot(Path(stage, Description.ROOT_FILE), packages=packages, **options)


def _proof(
    imported: ImportedRobot, shown: ImportedRobot, outputs: Outputs, folder: Path, packages: Mapping[str, Path]
) -> Proof:
    """Compare the source with the compiled artifact of the same format in a simulator such as MuJoCo."""
    format = FORMATS.get(imported.format)
    if format is None or format.prove is None or format.name not in outputs.entries:
        return Proof()
    Progress.step("proving the import in its engine")
    description = Description.from_path(folder / Description.ROOT_FILE)
    search = Request(replace(description, outputs=description.outputs.absolute()), packages=packages).search_meshes
    texts = write(seen_from(shown, folder), outputs)
    compiled = _compile(texts, packages, search=search, requested=[format.name])
    made = next((one.text for one in compiled.artifacts), None)
    if made is None:
        first = next(one.message for one in compiled.diagnostics if one.severity == ERROR)
        return Proof(unknown=" ".join(first.split()))
    opens = format.opens or (lambda name: name)
    found = compiled.meshes.by_name if compiled.meshes is not None else {}
    meshes = {called: str(file.absolute()) for name, file in found.items() for called in (name, opens(name)) if called}
    return format.prove(imported, made, meshes)


def _differs(what: str, found: Sequence[str]) -> Diagnostic:
    help = "this is a fault of rosorin-compile; please report it with the file"
    return error("import-differs", what, None, help, _some(found))


def _some(texts: Sequence[str]) -> tuple[Related, ...]:
    more = [and_more(len(texts) - _MAX_DIFFERENCES).strip()] if len(texts) > _MAX_DIFFERENCES else []
    return tuple(Related(text, None) for text in [*texts[:_MAX_DIFFERENCES], *more])


def model_differences(one: Robot, other: Robot, tolerance: float = NOISE) -> list[str]:
    """Return a sentence for each difference above ``tolerance`` (absolute or relative) between two robots."""

    def precision(key: object, *values: object) -> float:  # noqa: ARG001
        return tolerance / 2

    sides = leaves(replace(one, source=other.source)), leaves(other)
    known: tuple[Precision, Precision] = (precision, precision)
    describer = Describer(one, sides, known, tolerance)
    return [text for _, text in describer.describe(compare_leaves(*sides, known, tolerance))]


def _element_changes(source: Robot, made: Robot) -> list[str]:
    format = FORMATS.published_format()
    output = next((one for one in made.outputs if one.backend == format.name), None)
    before, after = list(source.urdf_elements), list(made.urdf_elements)
    if output is not None and format.brings is not None:
        before += format.brings(replace(source, sensors=(), control=(), controllers=()), output)
        after += format.brings(made, output)
    texts = without_collisions(before), without_collisions(after)
    return element_differences(*texts, followers_of(source, made.asks_for_humble))
