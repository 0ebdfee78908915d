"""What the commands of the core answer as JSON: the types of their results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypedDict

from rosorin_compile.language.explain.explanation import Answer, Explanation

Position = (
    float
    | tuple[float, float, float]
    | tuple[float, float, float, float, float, float]
    | tuple[float, float, float, float, float, float, float]
)


class Place(TypedDict):
    """A place in a file."""

    file: str
    line: Annotated[int, "from 1"]
    column: Annotated[int, "from 1"]


class _GivenPlace(TypedDict, total=False):
    file: Annotated[str, "where a file of arguments has it; left out for the command line"]
    line: int
    column: int


class GivenValue(_GivenPlace):
    """The value that is given to an argument."""

    text: Annotated[str, "the value as it is written"]


class _Given(TypedDict, total=False):
    value: Annotated[GivenValue, "what is given, where something is"]


class Argument(_Given):
    """An argument of a description."""

    name: str
    type: Annotated[str, "what a value has to be; any where nothing is said"]
    allowed: Annotated[list[str], "the values that may be given; empty: all of the type"]
    required: bool
    default: Annotated[str | None, "the text of the default; null where a value is required"]
    help: str
    file: Annotated[str, "where it is declared"]
    line: Annotated[int, "from 1"]
    column: Annotated[int, "from 1"]


class RobotArguments(TypedDict):
    """The arguments of one robot."""

    robot: str
    arguments: list[Argument]


class DifferenceSide(TypedDict):
    """One of the two robots."""

    source: Annotated[str, "The robot as it was named on the command line."]
    format: Annotated[str, "What it was read from: yaml for a description, else the name of the format."]
    robot: Annotated[str, "The name of the robot; that of the file where the format has no place for one."]
    links: Annotated[int, "How many links and frames it has."]
    joints: Annotated[int, "How many joints it has, fixed ones included."]


class _DifferenceMore(TypedDict, total=False):
    distance: Annotated[float, "How far it is off at most, in metres."]
    angle: Annotated[float, "How far it is turned at most, in radians."]
    when: Annotated[
        Literal["always", "away from 0"],
        "always: at every position of the joints; away from 0: only when the joint is away from position zero.",
    ]
    at: Annotated[dict[str, float], "The position of the joint at which it is off the most, in radians or metres."]


class DifferenceItem(_DifferenceMore):
    """One difference."""

    kind: Annotated[
        Literal["frame", "joint", "limit", "mass", "shape", "visual", "name", "other"],
        "frame: where a fixed frame sits; joint: where a joint sits and how it moves; limit: limits of a joint; mass: "
        "mass, centre of mass, inertia; shape: collision; visual: shapes and colours; name: new, removed and renamed "
        "links and joints; other: publishers, poses, servos, sensors, contacts, elements for URDF.",
    ]
    name: Annotated[str, "The link, joint or other thing, as A calls it, or B where it is new."]
    quantity: Annotated[str, "What of it differs, such as origin, axis, limit upper, mass, existence, name."]
    text: Annotated[str, "The difference in words, as the text output has it."]
    a: Annotated[float | str | None, "The value in A, in the unit that is given; null where A has none."]
    b: Annotated[float | str | None, "The value in B, in the unit that is given; null where B has none."]
    unit: Annotated[str, "The unit of both values; empty for a plain number or a text."]


class Difference(TypedDict):
    """Two robots compared by meaning."""

    a: DifferenceSide
    b: DifferenceSide
    same: Annotated[bool, "true: nothing that was compared differs, and the exit code is 0."]
    tolerance: Annotated[float, "What is no difference, besides what the digits of a file leave open: metres, radians."]
    differences: Annotated[list[DifferenceItem], "What differs, the most important kind first."]
    notes: Annotated[list[str], "What is written differently and means the same."]
    not_compared: Annotated[list[str], "What one of the two formats has no word for, or one of the files leaves out."]
    summary: Annotated[str, "All of it in one line."]


class Publisher(TypedDict):
    """Who publishes a transform."""

    name: str
    kind: str
    when: Annotated[str, "always, or the modes"]


class TransformStep(TypedDict):
    """A step on the way from one frame to the other."""

    parent: str
    child: str
    direction: Literal["up", "down"]
    joint: Annotated[str | None, "null for an edge of another node"]
    type: Annotated[str, "the type of the joint; node for an edge of another node"]
    publishers: list[Publisher]


class FrameTransform(TypedDict):
    """Where one frame sits in another."""

    source: str
    target: str
    positions: Annotated[
        dict[str, Position],
        "the positions of joints that are not at zero: radians or metres; of planar joints x, y, yaw, of floating ones "
        "x, y, z, roll, pitch, yaw, or x, y, z and a quaternion x, y, z, w, as they were given",
    ]
    translation: Annotated[tuple[float, float, float], "metres"]
    quaternion: Annotated[tuple[float, float, float, float], "x, y, z, w"]
    rpy: Annotated[tuple[float, float, float], "radians about fixed axes"]
    rpy_degrees: Annotated[tuple[float, float, float], "the same in degrees"]
    matrix: Annotated[list[list[float]], "four rows of four"]
    chain: list[TransformStep]


class FrameEdge(TypedDict):
    """An edge of the tree of frames."""

    parent: str
    child: str
    publisher: Annotated[str | None, "null: nobody publishes it"]
    why: Annotated[str | None, "why nobody does"]
    topic: str | None
    when: Annotated[str | None, "in which modes; null: always"]
    joint: Annotated[str | None, "null for an edge of another node"]
    type: Annotated[str | None, "the type of the joint"]


class FrameSituation(TypedDict):
    """The tree of frames in some modes."""

    when: Annotated[str, "the modes in words"]
    modes: Annotated[list[dict[str, bool]], "the same as values by name, a row for each combination"]
    frames: list[str]
    edges: list[FrameEdge]


class Frames(TypedDict):
    """The trees of frames of a robot."""

    robot: str
    situations: list[FrameSituation]


class FramePictures(TypedDict):
    """Pictures of the tree of frames, which `-o` names."""

    robot: str
    files: Annotated[list[str], "what was written"]


class ListedOutput(TypedDict):
    """An output of a robot."""

    name: Annotated[str, "its name under `outputs`"]
    format: str
    file: str


class Servos(TypedDict):
    """Servos that are calibrated alike."""

    name: str
    joints: list[str]
    rad_per_pulse: Annotated[float, "rad, or m of a joint that slides"]
    zero: Annotated[int, "the pulse of position zero"]
    flipped: Annotated[bool, "whether a larger pulse is a smaller position"]
    pulse_range: Annotated[tuple[int, int], "what can be sent"]


class JointPulse(TypedDict):
    """A pulse of a joint, and the position that it gives."""

    joint: str
    servos: Annotated[str, "the name of its servos"]
    pulse: int
    position: Annotated[float, "in the unit that is given"]
    unit: Literal["rad", "m"]
    degrees: Annotated[float | None, "null of a joint that slides"]
    asked: Annotated[float | None, "the position that was asked for; null where a pulse was"]
    off: Annotated[float | None, "how far the position is from it"]
    pulses_within_limits: Annotated[tuple[int, int] | None, "the pulses within the limits of the joint"]


class ComparedModel(TypedDict):
    """A driver's model that is held against the description, pulse by pulse."""

    file: str
    differences: Annotated[list[str], "a sentence each; none: the very positions described"]


class _WithModel(TypedDict, total=False):
    model: Annotated[ComparedModel, "with `--model`"]


class Pulses(_WithModel):
    """Pulses and the positions that they give."""

    servos: list[Servos]
    joints: Annotated[list[JointPulse], "what was asked for"]


class ListedSchema(TypedDict):
    """A schema that can be printed."""

    name: str
    what: Annotated[str, "whose form it describes"]


class RuleEntry(TypedDict):
    """What the id of a message means."""

    id: str
    what: Annotated[str, "what is wrong, as Markdown"]
    help: Annotated[str, "what to do"]
    topic: str
    accept: Annotated[str, "of what a description may accept it: link, joint, robot; empty: of nothing"]
    imported: Annotated[str, "when import accepts it by itself: always, lenient; empty: never"]
    asked: Annotated[str, "what has to be asked for to hear it"]


class _RobotMore(TypedDict, total=False):
    folder: Annotated[str, "the folder of its artifacts, where it compiles"]
    differences: Annotated[list[str], "what differs, in the lines that people read"]


class CheckedRobot(_RobotMore):
    """What came of one robot."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether nothing is wrong with it; the exit code is 0 where all are fine"]


class _WrittenMore(TypedDict, total=False):
    written: Annotated[list[str], "files that are new or others than before, as seen from the folder"]
    unchanged: list[str]
    removed: Annotated[list[str], "with `--prune`"]


class WrittenRobot(CheckedRobot, _WrittenMore):
    """What was written of one robot; with `--dry-run` what differs."""


class Checked(TypedDict):
    """What came of all robots that were asked for."""

    robots: list[CheckedRobot]


class Written(TypedDict):
    """What was written of all robots that were asked for."""

    robots: list[WrittenRobot]


class Started(TypedDict):
    """A new description."""

    description: Annotated[str, "its first file"]
    template: str
    schema: Annotated[str, "the schema for editors"]
    schema_written: bool
    schema_outdated: Annotated[bool, "whether one is there that is of another version"]


ANSWERS: dict[str, Any] = {
    "all": Written,
    "args": list[RobotArguments],
    "check": Checked,
    "diff": Difference,
    "explain": list[Explanation | Answer],
    "frames": Frames | FramePictures,
    "init": Started,
    "print": list[ListedOutput],
    "pulses": Pulses,
    "rule": list[RuleEntry],
    "schema": list[ListedSchema],
    "tf": FrameTransform | list[FrameTransform],
}
