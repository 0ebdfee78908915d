"""Round trip: the description is compiled before it is written, and its URDF held against the source by meaning."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from rosorin_compile.compare.precision import POSE_NOISE
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compiled import Compiled, compile_robot
from rosorin_compile.formats.imported import Imported, Outputs, Proof
from rosorin_compile.formats.mesh_files import urdf_file_name
from rosorin_compile.formats.reading import outputs_of
from rosorin_compile.model import Joint, Mesh, Robot, Shape, Transform
from rosorin_compile.request import Request
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import (
    ERROR,
    Diagnostic,
    Related,
    Source,
    Span,
    and_more,
    counted,
    error,
    has_errors,
    listed,
)
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map

from .description import write
from .repeats import with_parts
from .report import seen_from
from .same_model import by_elements, model_differences, read_back, section_differences, without_words

RULES = (
    Rule(
        "import-differs",
        "The description that import would write is not the same robot; nothing is written.",
        "That is a fault of the tool: please report it with the file.",
        Heading.READING,
    ),
    Rule(
        "import-untold",
        "The engine of the source's format (MuJoCo, Drake) finds something in the result that is otherwise than in the "
        "source, and no other message of the import says so; nothing is written.",
        "Please report it with the file. `--lenient` writes it all the same, with a warning.",
        Heading.READING,
    ),
)

STATES = 20
_SEED = 20
_REACH = 3.0  # rad or m: of each joint, whatever its limits
_MAX_SAID = 300
_MAX_TOLD = 20


class RoundTrip(NamedTuple):
    """How a description came through: its files (text by name), and how it was held against the source.

    ``outputs`` are the artifacts that it asks for, ``shown`` the robot as it is written, ``word`` the format in which
    it was read back. ``frames`` were compared at zero and at ``states`` random joint states; ``largest`` is the largest
    difference of any number in their poses (metres, or entries of rotation matrices). ``diagnostics`` are errors: what
    keeps it from being compared, or what differs. ``proof`` is what the engine of the source's format says of the
    artifact in it, and ``untold`` what it finds that nobody has said. ``reordered``: the joints that move stand in
    another order than in the source.
    """

    files: dict[str, str]
    outputs: Outputs
    diagnostics: list[Diagnostic]
    shown: Imported
    frames: int = 0
    states: int = 0
    largest: float = 0.0
    word: str = ""
    proof: Proof = Proof()
    untold: tuple[Diagnostic, ...] = ()
    reordered: bool = False


def check_round_trip(
    imported: Imported,
    folder: Path,
    parts: bool = True,
    plain: Map | None = None,
    packages: Mapping[str, Path] = MappingProxyType({}),
) -> RoundTrip:
    """Write the description of a robot into a folder that vanishes, compile it, and compare; the tree has to be there.

    ``folder`` is where it is going to stand: its meshes are found as seen from there, and in ``packages``. ``plain`` is
    its tree before elements of it became words. With ``parts``, what it has several times is written as a part, unless
    that comes out otherwise.
    """
    shown = with_parts(imported) if parts else imported
    if shown is not imported:
        trip = _round_trip(imported, shown, folder, plain, packages)
        # Controllers of MuJoCo count the joints of an MJCF.
        if not (trip.diagnostics or trip.untold or (trip.reordered and imported.format == "mjcf")):
            return trip
    return _round_trip(imported, imported, folder, plain, packages)


def _round_trip(
    imported: Imported, shown: Imported, folder: Path, plain: Map | None, packages: Mapping[str, Path]
) -> RoundTrip:
    """Return how a description came through that is written of ``shown``, the same robot, perhaps with parts."""
    schema = schema_beside(folder)
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        stage = Path(name)
        wanted = outputs_of(imported)
        files, compiled = _compiled(shown, stage, schema, wanted)
        if has_errors(compiled.diagnostics):
            # Most often only MuJoCo asks for more than the source says, a mass for instance.
            wanted = outputs_of(imported, _first_error(compiled.diagnostics))
            files, compiled = _compiled(shown, stage, schema, wanted)
        trip = RoundTrip(files, wanted, _relocated(compiled.diagnostics, folder), shown, word=FORMATS.published().word)
        if not trip.diagnostics:
            trip = _compared(imported, compiled, stage, trip, plain)
        if trip.diagnostics:
            return trip
        proof = _proof(imported, shown, wanted, folder, packages)
        return trip._replace(proof=proof, untold=(_untold(proof),) if proof.wrong else ())


def schema_beside(folder: Path) -> str:
    """Return where editors find the schema of a description in a folder; empty if there is none."""
    schema = Description.SCHEMA
    return (Path("..") / schema).as_posix() if files.is_file(folder.parent / schema) else ""


def _compiled(imported: Imported, stage: Path, schema: str, wanted: Outputs) -> tuple[dict[str, str], Compiled]:
    """Return the files of a description and what becomes of them."""
    files = write(imported, wanted, schema)
    for name, text in files.items():
        (stage / name).write_text(text, "utf-8")
    return files, compile_robot(stage / Description.ROOT_FILE, exact=True)


def _compared(imported: Imported, compiled: Compiled, stage: Path, trip: RoundTrip, plain: Map | None) -> RoundTrip:
    """Return the round trip with what the comparison of the source with the description and with its artifact says."""
    tree, format = plain or imported.whole, FORMATS.published()
    source, said = imported._replace(tree=tree).robot, {one.backend: one.text for one in compiled.artifacts}
    beside = [one for one in FORMATS.values() if one.join is not None and one.name in said]
    back = read_back(stage, said, tree, beside)
    again = back.robot
    made = compiled.robot
    if source is None or again is None or made is None:
        broken = [d.message for d in back.diagnostics if d.severity == ERROR]
        return trip._replace(diagnostics=[_failed(f"the compiled {format.word} cannot be read back", broken)])
    what = f"compiled {format.word}"
    found = []
    if plain is not None:
        found += [f"{what}: {text}" for text in by_elements(source, again, made)]
        made, again = without_words(made, source), without_words(again, source)
    found += [f"description: {text}" for text in model_differences(source, made, 0.0)]
    found += [f"{what}: {text}" for text in model_differences(_with_urdf_names(source), again, carried_by_urdf=True)]
    for companion in beside:
        for section in companion.joins:
            lines = section_differences(source, again, section)
            found += [f"compiled {companion.word}: {text}" for text in lines]
    largest = 0.0 if found else largest_difference(source, again)
    if largest > POSE_NOISE:
        found.append(f"{what}: frames differ by {largest:.2g}")
    if found:
        return trip._replace(diagnostics=[_failed("the description would not be the same robot", found)])
    reordered = _moving(source) != _moving(again)
    return trip._replace(frames=len(source.links), states=STATES, largest=largest, reordered=reordered)


def _with_urdf_names(robot: Robot) -> Robot:
    """Return a robot whose meshes and textures have the names that a URDF gives them."""

    def renamed(shapes: tuple[Shape, ...]) -> tuple[Shape, ...]:
        made = []
        for shape in shapes:
            solid = shape.geometry
            solid = replace(solid, file=urdf_file_name(solid.file)) if isinstance(solid, Mesh) else solid
            made.append(replace(shape, geometry=solid, texture=urdf_file_name(shape.texture)))
        return tuple(made)

    if not any(":" in name for name in _files_of(robot)):
        return robot
    links = (replace(one, visual=renamed(one.visual), collision=renamed(one.collision)) for one in robot.links)
    materials = (replace(one, texture=urdf_file_name(one.texture)) for one in robot.materials)
    return replace(robot, links=tuple(links), materials=tuple(materials))


def _files_of(robot: Robot) -> list[str]:
    shapes = [shape for link in robot.links for shape in (*link.visual, *link.collision)]
    meshes = [shape.geometry.file for shape in shapes if isinstance(shape.geometry, Mesh)]
    return [*meshes, *(shape.texture for shape in shapes), *(one.texture for one in robot.materials)]


def _moving(robot: Robot) -> list[str]:
    return [joint.name for joint in robot.joints if not joint.is_fixed]


def _proof(imported: Imported, shown: Imported, wanted: Outputs, folder: Path, packages: Mapping[str, Path]) -> Proof:
    """Return how the engine of the source's format tells the artifact of that format from the source, if it can.

    It is the very text that is going to be written: with the numbers and the meshes that it will have.
    """
    format = FORMATS.get(imported.format)
    if format is None or format.prove is None or format.name not in wanted.entries:
        return Proof()
    Progress.step("proving the import in its engine")
    outputs = Description.at(folder / Description.ROOT_FILE).outputs.absolute()
    placed = replace(Description.at(folder / Description.ROOT_FILE), outputs=outputs)
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as name:
        for file, text in write(seen_from(shown, folder), wanted).items():
            Path(name, file).write_text(text, "utf-8")
        compiled = compile_robot(
            Path(name, Description.ROOT_FILE),
            packages=packages,
            search=Request(placed, packages=packages).search_meshes,
            requested=[format.name],
        )
    made = next((one.text for one in compiled.artifacts), None)
    if made is None:
        return Proof(unknown=_first_error(compiled.diagnostics))
    opens = format.opens or (lambda name: name)
    found = compiled.meshes.by_name if compiled.meshes is not None else {}
    files = {called: str(file.absolute()) for name, file in found.items() for called in (name, opens(name)) if called}
    return format.prove(imported, made, files)


def _untold(proof: Proof) -> Diagnostic:
    """Return the error about what differs though no message of the import says so."""
    texts = proof.texts
    what = "comes out" if len(texts) == 1 else "come out"
    message = f"{counted(len(texts), 'thing')} {what} otherwise than in the source, and nothing above says so"
    message += f": {listed(list(proof.wrong))}"
    more = [and_more(len(texts) - _MAX_TOLD).strip()] if len(texts) > _MAX_TOLD else []
    related = tuple(Related(text, None) for text in [*texts[:_MAX_TOLD], *more])
    help = "please report it with the file; --lenient writes it all the same"
    return Diagnostic("import-untold", ERROR, message, None, related, help)


def largest_difference(one: Robot, other: Robot) -> float:
    """Return the largest difference between the poses of all frames, at zero and at random states of the joints."""
    largest = 0.0
    states = [{}, *random_states([(joint, -_REACH, _REACH) for joint in one.joints], STATES, _SEED)]
    for number, state in enumerate(states):
        Progress.step("proving the import", number, len(states))
        first, second = one.poses_in_root(state), other.poses_in_root(_in_urdf(one, state))
        largest = max([largest, *(_apart(pose, second[name]) for name, pose in first.items())])
    return largest


def random_states(joints: Iterable[tuple[Joint, float, float]], count: int, seed: int) -> list[dict[str, Any]]:
    """Return states of joints, the same for a seed: each number (rad or m) between the two limits of its joint.

    A joint has as many numbers as it has ``coordinates``; those of an orientation are not normalised.
    """
    chance = random.Random(seed)  # noqa: S311 - the same states in every run
    drawn = list(joints)
    return [
        {joint.name: _random_position(joint, low, high, chance) for joint, low, high in drawn} for _ in range(count)
    ]


def _random_position(joint: Joint, low: float, high: float, chance: random.Random) -> float | Sequence[float]:
    numbers = [chance.uniform(low, high) for _ in joint.coordinates]
    return numbers if len(numbers) > 1 else sum(numbers)


def _in_urdf(robot: Robot, state: Mapping[str, float | Sequence[float]]) -> dict[str, float | Sequence[float]]:
    """Return a state as a URDF has it, where a ball joint is a floating one."""
    balls = {joint.name for joint in robot.joints if joint.type == "ball"}
    return {name: (0.0, 0.0, 0.0, *at) if name in balls else at for name, at in state.items()}  # type: ignore[misc]


def _apart(one: Transform, other: Transform) -> float:
    """Return the largest difference between the numbers of two transforms."""
    pairs = zip((*one.rows, one.xyz), (*other.rows, other.xyz), strict=True)
    return max(abs(a - b) for vectors in pairs for a, b in zip(*vectors, strict=True))


def _first_error(diagnostics: Sequence[Diagnostic]) -> str:
    message = next(" ".join(d.message.split()) for d in diagnostics if d.severity == ERROR)
    return message if len(message) <= _MAX_SAID else f"{message[:_MAX_SAID]}..."


def _relocated(diagnostics: Sequence[Diagnostic], folder: Path) -> list[Diagnostic]:
    """Return errors whose places are those in the folder where the description would have stood."""

    def moved(span: Span | None) -> Span | None:
        if span is None:
            return None
        return span._replace(source=Source(str(folder / Path(span.source.path).name), span.source.text))

    return [
        replace(d, span=moved(d.span), related=tuple(Related(r.message, moved(r.span)) for r in d.related))
        for d in diagnostics
        if d.severity == ERROR
    ]


def _failed(what: str, found: Sequence[str]) -> Diagnostic:
    """Return the error about a round trip that failed."""
    more = [and_more(len(found) - _MAX_TOLD).strip()] if len(found) > _MAX_TOLD else []
    related = [Related(text, None) for text in [*found[:_MAX_TOLD], *more]]
    help = "this is a fault of rosorin-compile; please report it with the file"
    return error("import-differs", what, None, help, related)
