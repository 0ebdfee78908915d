"""Facts: the engine that reads compiled artifacts back and holds them against the model, for faults of templates."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.formats import FORMATS, Artifact, Fact, Format, Value
from rosorin_compile.formats.expectation import Expectation
from rosorin_compile.formats.facts import COLLISION, Deviations, Solid
from rosorin_compile.language.validator import misfits
from rosorin_compile.model import Inertial, Mesh, Output, Robot, Shape
from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import WRITING, Rule

from ..solids_old import remainder, same_set, solid_from, straight
from ..tolerance import NOISE, same_turn, same_value
from ..view import View, called, joints_called, named_as, turn_of, view_of
from . import Found, Proof, Tolerance

RULES = (
    Rule(
        "artifacts-disagree",
        "Artifacts that were just compiled do not say the same.",
        "That is a fault of the tool: please report it.",
        WRITING,
    ),
)

_RULE = "artifacts-disagree"
_HELP = "a template or a backend is at fault, not the description: please report it"
# What the way through frames, quaternions and half sizes costs (m, and rotation entries).
_TOLERANCE = Tolerance.POSE


class _Reading(NamedTuple):
    """An artifact, what it says, the parents of its frames, and what its schema is about, if that was read."""

    artifact: Artifact
    view: View
    parents: Mapping[str, str]
    data: object = None

    @property
    def format(self) -> Format:
        """The format of the artifact."""
        return FORMATS[self.artifact.backend]

    def output(self, robot: Robot) -> Output:
        """Return the output of the robot that asks for the artifact."""
        return next(output for output in robot.outputs if output.name == self.artifact.output)


def _misfits(artifact: Artifact, data: object = None) -> list[str]:
    """Return a sentence for each place where a JSON artifact does not fit its published schema.

    ``data`` is what the artifact says, if it was read already.
    """
    format = FORMATS[artifact.backend]
    name = format.proving.schema
    if name and data is None:
        data = (format.proving.data or json_of)(artifact.text)
    problems = misfits(name, data) if name else []
    return [f"{artifact.file} does not fit schemas/{name}.schema.json: {p}" for p in problems]


def agreement(robot: Robot, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return an error for each place where a compiled artifact does not say what the model says."""
    return [error(_RULE, text, None, _HELP) for text in Proof.of(robot, artifacts, by_facts).texts]


def by_facts(robot: Robot, artifacts: Sequence[Artifact]) -> Found:
    """Return where compiled artifacts do not say what the model says, as far as they print.

    Held against the model: the frames that an artifact carries, where they sit, their joints with axis, limits and
    mimic, masses, centres of mass and inertias, and collision shapes.

    Each artifact is held against the model by itself, and let go; only where one is wrong are all of them read in full,
    for the words.
    """
    model = Expectation(robot)
    for number, artifact in enumerate(artifacts):
        Progress.step(f"proving {artifact.file},", number, len(artifacts))
        if not agrees(robot, artifact, model):
            return Found(_disagreements(robot, artifacts))
    return Found()


def agrees(robot: Robot, artifact: Artifact, model: Expectation) -> bool:
    """Say whether a compiled artifact says what the model says; ``model`` is what is known of the robot."""
    try:
        known = _known(robot, artifact, model)
        reading = _reading(artifact, known)
    except ValueError:
        return False
    return reading is None or not (
        _misfits(artifact, reading.data) or any(True for _ in _wrong(robot, reading, known, ()))
    )


def _known(robot: Robot, artifact: Artifact, model: Expectation) -> Expectation:
    """Return what the model says, as an artifact has to say it.

    Its links may have other names, and weigh more, for they carry others.
    """
    weighs, others = FORMATS[artifact.backend].proving.inertials, dict[str, Inertial]()
    if weighs is not None:
        output = next(output for output in robot.outputs if output.name == artifact.output)
        own = {link.name: link.inertial for link in robot.links}
        weights = ((name, one) for name, one in weighs(robot, output).items() if one is not own.get(name))
        others = {name: one for name, one in weights if name in own and one != own[name]}
    return model.of(called(robot, artifact), others, joints_called(robot, artifact))


def _reading(artifact: Artifact, known: Expectation) -> _Reading | None:
    """Return an artifact and what it says otherwise than is known; None for one that is not read back.

    Raises ValueError.
    """
    format = FORMATS[artifact.backend]
    if format.facts is None:
        return None
    if format.proving.against is not None:
        return _held(artifact, format.proving.against(artifact.text, known))
    return _whole(artifact, view_of(format.facts(artifact.text), known.names))


def _whole(artifact: Artifact, view: View) -> _Reading:
    """Return an artifact with all that it says."""
    return _Reading(artifact, view, view.parents())


def _held(artifact: Artifact, held: Deviations) -> _Reading:
    """Return an artifact that has been held against what is known."""
    view = view_of(held.facts, {})
    shapes = {(link, COLLISION): tuple(map(straight, solids)) for link, solids in held.solids.items()}
    return _Reading(artifact, view._replace(shapes=shapes, names=held.names), held.parents, held.data)


def _disagreements(robot: Robot, artifacts: Sequence[Artifact]) -> list[tuple[str, str]]:
    """Return each place where artifacts do not say what the model says, with those that do; first what is damaged."""
    readings: list[_Reading] = []
    found: list[tuple[str, str]] = []
    for artifact in artifacts:
        read = FORMATS[artifact.backend].facts
        if read is None:
            continue
        try:
            facts = named_as(read(artifact.text), joints_called(robot, artifact))
            reading = _whole(artifact, view_of(facts, called(robot, artifact)))
        except ValueError as problem:
            found.append(("reading", f"{artifact.file} cannot be read back: {problem}"))
        else:
            found += [("reading", text) for text in _misfits(artifact)]
            readings.append(reading)
    readings.sort(key=lambda reading: (reading.format.rank, reading.artifact.output))
    model = Expectation(robot)
    for reading in readings:
        wrong = _wrong(robot, reading, _known(robot, reading.artifact, model), readings)
        found += [(f"facts of {reading.artifact.file}", text) for text in wrong]
    return found


def _wrong(robot: Robot, reading: _Reading, known: Expectation, readings: Sequence[_Reading]) -> Iterator[str]:
    """Yield a sentence for each place where one artifact does not say what the model says."""
    yield from _frames(robot, reading)
    yield from _others(robot, reading)
    yield from _values(robot, reading, known, readings)
    yield from _turns(reading, known, readings)
    yield from _shapes(robot, reading, known)


def _frames(robot: Robot, reading: _Reading) -> Iterator[str]:
    """Yield a sentence for each frame that an artifact should carry and does not."""
    has_to_carry = reading.format.proving.frames
    # What publishers are not to read has other frames: its format itself says which are missing.
    if has_to_carry is None or reading.artifact.withheld:
        return
    for frame in has_to_carry(robot):
        if not reading.parents.get(frame):
            yield f"{reading.artifact.file} does not carry the frame {frame}, which it should"


def _others(robot: Robot, reading: _Reading) -> Iterator[str]:
    """Yield a sentence for each thing that an artifact says wrongly, and its format alone can tell."""
    if reading.format.proving.disagreements is None:
        return
    try:
        sentences = list(reading.format.proving.disagreements(robot, reading.output(robot), reading.artifact.text))
    except (TypeError, ValueError) as problem:
        sentences = [f"it cannot be read back: {problem}"]
    yield from (f"{reading.artifact.file}: {sentence}" for sentence in sentences)


def _values(robot: Robot, reading: _Reading, known: Expectation, readings: Sequence[_Reading]) -> Iterator[str]:
    for fact, value in reading.view.plain.items():
        meant = known.value(fact)
        if meant is None or same_value(value, meant, NOISE) or _cannot_say(robot, reading, fact):
            continue
        others = (other for other in readings if same_value(other.view.plain.get(fact), meant, NOISE))
        mine, theirs = _both(value, meant)
        yield _sentence(str(fact.about), reading, mine, theirs, next(others, None))


def _cannot_say(robot: Robot, reading: _Reading, fact: Fact) -> bool:
    return reading.format.proving.cannot_say is not None and reading.format.proving.cannot_say(robot, fact)


def _both(value: Value, meant: Value) -> tuple[str, str]:
    """Return two different values in print, with as many digits as show the difference."""
    from ..wording import number_pair, value_text

    if isinstance(value.value, str) or isinstance(meant.value, str):
        return value_text(value), value_text(meant)
    before, after = number_pair(value.value, meant.value)
    return f"{before} {value.unit}".rstrip(), f"{after} {value.unit}".rstrip()


def _turns(reading: _Reading, known: Expectation, readings: Sequence[_Reading]) -> Iterator[str]:
    for frame, turn in reading.view.turns.items():
        meant = turn_of(known.block("frame", frame))
        if meant is None or same_turn(turn, meant):
            continue
        from ..wording import number_pair  # only where something is wrong

        others = (other for other in readings if same_turn(other.view.turns.get(frame), meant))
        pairs = [number_pair(a, b) for a, b in zip(turn.rpy, meant.rpy, strict=True)]
        mine, theirs = (f"{' '.join(numbers)} rad" for numbers in zip(*pairs, strict=True))
        yield _sentence(f"{frame} roll pitch yaw", reading, mine, theirs, next(others, None))


def _sentence(what: str, reading: _Reading, mine: str, theirs: str, other: _Reading | None) -> str:
    others = f"{other.artifact.file} and the model say" if other else "the model says"
    return f"{what}: {reading.artifact.file} says {mine}, {others} {theirs}"


def _shapes(robot: Robot, reading: _Reading, known: Expectation) -> Iterator[str]:
    """Yield a sentence for each link whose collision shapes in an artifact are not those of the model."""
    told = {link: solids for (link, purpose), solids in reading.view.shapes.items() if purpose == COLLISION}
    format, output = reading.format, reading.output(robot)
    # By the identities of the solids of an artifact and of the shapes of the model, which are kept for that.
    fine: dict[tuple[tuple[int, ...], tuple[int, ...]], Sequence[Shape]] = {}
    for link in sorted(reading.view.names) if format.proving.all_solids and told else sorted(told):
        shapes, solids = _meant(robot, link, format, output, reading.view.names), told.get(link, ())
        if shapes is None:
            continue
        both = tuple(map(id, solids)), tuple(map(id, shapes))
        if both in fine:
            continue
        meant = [_solid(solid, known) for shape in shapes for solid in shape.solids()]
        # Names of shapes and the like are not in every artifact.
        solids = tuple([solid._replace(words=()) if solid.words else solid for solid in solids])
        if same_set(solids, meant):
            fine[both] = shapes
            continue
        wrong = len(remainder(solids, meant).removed)
        message = f"{link} collision: {wrong} of {len(solids)} shapes in {reading.artifact.file} are not in the model"
        if len(solids) != len(meant):
            message = f"{link} collision: {reading.artifact.file} has {len(solids)} shapes, the model {len(meant)}"
        yield message


def _solid(shape: Shape, known: Expectation) -> Solid:
    """Return a shape as a solid; the same shapes are asked for, for each artifact."""
    found = known.solids.get(id(shape))
    if found is None:
        found = known.solids[id(shape)] = (shape, solid_from(shape, _TOLERANCE))
    return found[1]


def _meant(robot: Robot, link: str, format: Format, output: Output, names: frozenset[str]) -> Sequence[Shape] | None:
    """Return the shapes that a link should have in an artifact; None if they cannot be compared."""
    if link not in robot.link:
        return None
    own: Sequence[Shape] | None = robot.link[link].collision
    if format.proving.solids is not None:
        own = format.proving.solids(robot, link, output, names)
    for shape in own or ():
        if isinstance(shape.geometry, Mesh):
            return None
    return own
