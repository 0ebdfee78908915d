"""Write an HTML page that shows the changes of robots, as a list and as an overlay of the previous version.

``check`` overlays the compiled robot on the robot of the committed artifacts, ``diff`` overlays the second robot on the
first robot. A page can have several robots.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Mesh, Robot
from rosorin_compile.output.atomic_files import write_file
from rosorin_compile.source.diagnostics import count_of

from .overlay import Overlay, moves, of_two, robot_before
from .page import html, left_out
from .page.data import before_data
from .page.images import Data, EmbeddedFiles, mesh_table
from .robot_view import RobotView, load, nameless, on_disk

if TYPE_CHECKING:
    from rosorin_compile.compare.artifacts import Change
    from rosorin_compile.compare.difference import Difference
    from rosorin_compile.compare.golden_check import GoldenDifferences
    from rosorin_compile.formats.compilation import CompileResult
    from rosorin_compile.request import Request

COMMITTED = "what is committed"


class Picture(NamedTuple):
    """A robot on an HTML page of changes: its current version, its previous version (or None), and the changes.

    ``files`` are the mesh files of the previous version by name; ``inputs`` are all files that the page was made from.
    """

    shown: RobotView
    before: Overlay | None
    files: Mapping[str, Path]
    inputs: tuple[Path, ...]
    changes: Sequence[Data] = ()
    notes: Sequence[str] = ()
    said: str = "nothing is committed to compare with"


class ChangesPage(NamedTuple):
    """The result of writing an HTML page of changes; if ``robots`` is 0, no file was written."""

    file: Path
    robots: int = 0
    bytes: int = 0
    left_out: str = ""


class Pictures:
    """Collects robots for an HTML page of changes, and writes the page."""

    def __init__(self, file: Path, meshes: bool = True, max_megabytes: float | None = None) -> None:
        self.file = file
        self.embedding = EmbeddedFiles(max_megabytes) if meshes else None
        self.taken: list[Picture] = []

    def take(self, request: Request, compiled: CompileResult, found: GoldenDifferences) -> None:
        """Add a robot to the page, with its changes since its artifacts were committed."""
        shown, outputs = load(request)[0], request.description.outputs
        comparison, committed, meshes = found.comparison, found.committed, found.meshes
        if shown is None:
            return
        inputs = (*compiled.inputs, *shown.meshes.values(), *(outputs / name for name in committed))
        if not committed:
            self.taken.append(Picture(shown, None, {}, inputs))
            return
        before = moves(robot_before(shown.robot, comparison.pairs), shown.robot)
        changes = [change_data(change, [shown.robot, before.old]) for change in comparison.changes]
        notes = [f"{text.file}: {text.remark}" for text in comparison.texts if text.remark]
        if not changes:
            notes += [f"{text.file}: different text" for text in comparison.texts if not text.remark]
        notes += [f"{name}: {what}" for name, what in meshes]
        other = {name for name, _ in meshes if name in committed}
        used = compiled.meshes.found if compiled.meshes else ()
        before = before.with_meshes({mesh.named.name for mesh in used if other.intersection(mesh.places)})
        unchanged = "no change that is compared by meaning" if notes else f"no change: this is {COMMITTED}"
        summary = f"{count_of(len(changes), 'change')} against {COMMITTED}" if changes else unchanged
        old_files = {**shown.meshes, **{name: outputs / name for name in committed}}
        self.taken.append(Picture(shown, before, old_files, inputs, changes, notes, summary))

    def take_sides(self, requests: Sequence[Request], found: Difference, prefix: str | None) -> None:
        """Add two compared robots to the page if both can be shown.

        ``prefix`` is the prefix of all names in the second robot, "" for none, or None to detect it.
        """
        first, second = (load(request)[0] for request in requests)
        if first is None or second is None:
            return
        a, b = found.sides
        overlay = of_two(found, prefix)
        changes = []
        for item in found.items:
            colours = _colours(item.before, item.after) if item.quantity == "colour" else None
            changes.append(_entry(item.text, overlay.frames.get(item.name, ""), (), colours))
        notes = [f"note: {note}" for note in found.notes]
        notes += [f"not compared: {line}" for line in found.not_compared]
        summary = f"{Path(a.label).name} -> {Path(b.label).name}: {found.summary()}"
        inputs = tuple(file for one in (first, second) for file in (*one.files, *one.meshes.values()))
        self.taken.append(Picture(second, overlay, first.meshes, inputs, changes, notes, summary))

    def write(self) -> ChangesPage:
        """Write the HTML page of changes; robots with changes are first. Raises OutputError."""
        if not self.taken:
            return ChangesPage(self.file)
        ordered = sorted(self.taken, key=lambda one: not (one.changes or one.notes))
        first, *others = [self._robot(one) for one in ordered]
        text = html({**first, "others": others} if others else first).encode()
        write_file(self.file, text, [file for one in self.taken for file in one.inputs])
        left = self.embedding.left if self.embedding else {}
        return ChangesPage(self.file, 1 + len(others), len(text), left_out(left) if left else "")

    def _robot(self, one: Picture) -> Data:
        data = on_disk(one.shown, self.embedding)
        entry: Data = {"robot": data, "changes": one.changes, "notes": one.notes, "said": one.said}
        if one.before is None:
            return entry
        before = before_data(one.before.old, one.before.shapes, one.before.at)
        if self.embedding:
            drawn = [shape.geometry for shapes in one.before.shapes.values() for shape in shapes]
            names = list(dict.fromkeys(geometry.file for geometry in drawn if isinstance(geometry, Mesh)))
            before = nameless(before | {"meshes": mesh_table(names, one.files, self.embedding)})
            before["meshes"] = {n: mesh for n, mesh in before["meshes"].items() if mesh != data["meshes"].get(n)}
        return {**entry, "before": before, "moved": dict(one.before.how)}


def change_data(change: Change, robots: Iterable[Robot]) -> Data:
    """Convert a change to JSON data for the HTML page, with the frame that shows the change, if any."""
    _, is_colour, values = change.text.rpartition(" colour ")
    colours = _colours(*values.split(" -> ")) if is_colour and " -> " in values else None
    return _entry(change.words(), _frame(change.kind, change.name, robots), change.artifacts, colours)


def _entry(text: str, frame: str, artifacts: Sequence[str], colours: Data | None) -> Data:
    made = {"text": text, "frame": frame, "colours": frame and colours, "artifacts": list(artifacts)}
    return {key: value for key, value in made.items() if value}


def _colours(was: object, became: object) -> Data:
    texts = {"was": str(was).split(), "is": str(became).split()}
    return {key: [*map(float, numbers)] if len(numbers) == 4 else None for key, numbers in texts.items()}


def _frame(kind: str, name: str, robots: Iterable[Robot]) -> str:
    plain = name.split(" when ")[0].split(" below ")[0]  # drop the condition in the name of a publisher
    frames: list[str] = []
    for robot in robots:
        frames += [robot.joint[name].child] if kind == "joint" and name in robot.joint else []
        frames += [sensor.frame for sensor in robot.sensors if kind == "sensor" and sensor.name == name]
        frames += [plain] if plain in robot.link else []
        joints = next((group.joints for group in robot.servos if group.name == name), ())
        frames += [robot.joint[joint].child for joint in joints[:1] if joint in robot.joint]
    return next(iter(frames), "")
