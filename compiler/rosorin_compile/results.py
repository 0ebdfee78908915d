"""The results of the Python API, as frozen dataclasses: those of the core here, those of features where they are made.

Each has ``diagnostics``. What is wrong with the files of a robot is among them, and never an exception.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.compare.difference import Difference, Item
from rosorin_compile.formats.compiled import Compiled, Reading, Variant
from rosorin_compile.formats.format import Artifact
from rosorin_compile.language.arguments import Argument
from rosorin_compile.language.explain import Answer, Explanation, NamedValue
from rosorin_compile.language.explain_text import lines
from rosorin_compile.model import Output, Robot
from rosorin_compile.queries import FrameTransform, JointPulse, Servos, TransformPublisher, TransformStep
from rosorin_compile.source.diagnostics import Diagnostic, RequestError, UnknownName, has_errors
from rosorin_compile.source.rule_registry import Rule
from rosorin_compile.viewer.frames import FrameEdge, Frames, FrameSituation
from rosorin_compile.viewer.picture.draw import Picture
from rosorin_compile.viewer.showing import Page

if TYPE_CHECKING:
    from rosorin_compile.importing.new_robot import NewRobot
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.checking import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.output.committed import Committed
    from rosorin_compile.recordings.results import Verified
    from rosorin_compile.variants.writing import WrittenVariants

__all__ = [
    "Argument",
    "Arguments",
    "Artifact",
    "Checked",
    "CheckedPhysics",
    "CollisionMatrix",
    "Compiled",
    "Diagnostic",
    "Difference",
    "Explained",
    "FrameEdge",
    "FrameSituation",
    "FrameTransform",
    "Frames",
    "Item",
    "JointPulse",
    "ModelComparison",
    "NewRobot",
    "Outputs",
    "Page",
    "Picture",
    "Pulses",
    "Reading",
    "RequestError",
    "Robot",
    "Rules",
    "Servos",
    "Simulated",
    "TransformPublisher",
    "TransformStep",
    "Transforms",
    "UnknownName",
    "Variant",
    "Verified",
    "Written",
    "WrittenVariants",
]


@dataclass(frozen=True)
class Checked:
    """The comparison of the committed artifacts of a robot with its description.

    ``differing`` are the files that are missing, changed or no artifacts any more; ``lines`` describe the differences
    as ``rosorin-compile check`` prints them. Both are empty if ``compiled`` has errors.
    """

    compiled: Compiled
    folder: Path
    differing: tuple[str, ...] = ()
    lines: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    committed: Committed | None = field(default=None, repr=False)

    @property
    def same(self) -> bool:
        """Whether the robot has no errors, no engine rejects an artifact, and each file is as committed."""
        return not self.differing and not has_errors(self.diagnostics)

    def __str__(self) -> str:
        """Return the differences as lines."""
        return "\n".join(self.lines)


@dataclass(frozen=True)
class Written:
    """The files in ``folder`` after the artifacts of a robot were written, by name.

    ``kept`` are not artifacts and were left alone; ``removed`` were deleted by ``prune``. With errors in
    ``diagnostics`` nothing was written.
    """

    compiled: Compiled
    folder: Path
    written: tuple[str, ...] = ()
    unchanged: tuple[str, ...] = ()
    kept: tuple[str, ...] = ()
    removed: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Explained:
    """The poses of things of a robot, and the position in YAML of each of their numbers; empty with errors."""

    answers: tuple[Explanation | Answer | NamedValue, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()

    def __str__(self) -> str:
        """Return the text that ``rosorin-compile explain`` prints."""
        return "\n".join(line for answer in self.answers for line in lines(answer))


@dataclass(frozen=True)
class Transforms:
    """The pose of a frame in another, for each state of the joints.

    ``swept`` has the unit of each joint with a sweep. ``transforms`` is empty with errors in ``diagnostics``, and
    without ``robot`` the errors are in its files.
    """

    transforms: tuple[FrameTransform, ...] = ()
    swept: Mapping[str, str] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)


@dataclass(frozen=True)
class ModelComparison:
    """A comparison with a driver's model of the servos, pulse by pulse: how many, and a sentence per difference."""

    file: str
    joints: int
    pulses: int
    differences: tuple[str, ...]


@dataclass(frozen=True)
class Pulses:
    """The calibration of the servos of a robot, and the requested pulses with the positions that they set.

    ``without_servo`` are joints of the requested pose that have no servo.
    """

    servos: tuple[Servos, ...] = ()
    joints: tuple[JointPulse, ...] = ()
    model: ModelComparison | None = None
    without_servo: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Arguments:
    """The arguments that a description declares, and the values that they are set to."""

    robot: str
    arguments: tuple[Argument, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Outputs:
    """The outputs that a robot lists; None with errors."""

    robot: str
    outputs: tuple[Output, ...] | None = None
    diagnostics: tuple[Diagnostic, ...] = ()


@dataclass(frozen=True)
class Rules:
    """The meaning of rule ids, and the errors of plug-ins that declare rules."""

    rules: tuple[Rule, ...]
    diagnostics: tuple[Diagnostic, ...] = ()


def __getattr__(name: str) -> object:
    """Return a result of a large feature, which is imported at this moment."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from rosorin_compile.importing.new_robot import NewRobot
    from rosorin_compile.mujoco.collisions.matrix import CollisionMatrix
    from rosorin_compile.mujoco.physics.checking import CheckedPhysics
    from rosorin_compile.mujoco.simulate.simulation import Simulated
    from rosorin_compile.recordings.results import Verified
    from rosorin_compile.variants.writing import WrittenVariants

    for kind in (CheckedPhysics, CollisionMatrix, NewRobot, Simulated, Verified, WrittenVariants):
        globals()[kind.__name__] = kind
    return globals()[name]
