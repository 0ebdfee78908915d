"""A change as a picture: the page of a robot with the robot before under it, and what changed, by meaning.

``check`` draws what is committed under what was compiled, ``diff`` one robot under another one; one page may hold
several robots.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Robot
from rosorin_compile.output import write_file
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import counted

from .overlay import Overlay, of_two
from .overlay import before as before_of
from .page import MAX_MEGABYTES, Embedding, data_of, html, left_out
from .page.data import Data, before_data
from .showing import Shown, look, nameless, on_disk

if TYPE_CHECKING:
    from rosorin_compile.compare.changes import Change
    from rosorin_compile.compare.difference import Difference
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.output.committed import Comparison
    from rosorin_compile.request import Request


COMMITTED = "what is committed"
_RGBA = "rgba"


class Picture(NamedTuple):
    """One robot of a page: the robot of now, what was before (None: nothing), and what is said of the difference.

    ``files`` are the meshes of before by name; ``inputs`` the files that the page is made of.
    """

    shown: Shown
    before: Overlay | None
    files: Mapping[str, Path]
    changes: list[Data]
    notes: list[str]
    said: str
    inputs: tuple[Path, ...] = ()


@dataclass(frozen=True)
class ChangesPage:
    """A page that was written: how many robots it shows, and what is left out of it; no robot: nothing was written.

    ``removed`` says that the page of an earlier run was removed.
    """

    file: Path
    robots: int = 0
    bytes: int = 0
    left_out: str = ""
    removed: bool = False


class Pictures:
    """The robots of one page, as they come."""

    def __init__(self, file: Path, meshes: bool = True, max_megabytes: float | None = None) -> None:
        self.file = file
        self.with_meshes = meshes
        limit = MAX_MEGABYTES if max_megabytes is None else max_megabytes
        self.embedding = Embedding(int(limit * 1_000_000))
        self.taken: list[Picture] = []

    def take(
        self,
        request: Request,
        compiled: Compiled,
        comparison: Comparison,
        committed: Mapping[str, bytes],
        meshes: Sequence[tuple[str, str]],
    ) -> None:
        """Add the changes of one robot since its artifacts were committed."""
        picture = of_committed(request, compiled, comparison, committed, meshes)
        self.taken += [picture] if picture is not None else []

    def take_sides(
        self,
        requests: Sequence[Request],
        found: Difference,
        prefix: str | None,
    ) -> None:
        """Add the differences of two robots, if both can be shown; ``prefix`` as in ``of_sides``."""
        first, second = (look(one).shown for one in requests)
        if first is not None and second is not None:
            self.taken.append(of_sides((first, second), found, prefix))

    def clear(self) -> None:
        """Forget the robots that were taken."""
        self.taken.clear()

    def write(self) -> ChangesPage:
        """Write the page, robots that changed first. Raises OutputError."""
        if not self.taken:
            return ChangesPage(self.file, removed=_removed(self.file))
        ordered = sorted(self.taken, key=lambda one: not (one.changes or one.notes))
        entries = [self._entry(one) for one in ordered]
        text = html({**entries[0], "others": entries[1:]} if entries[1:] else entries[0])
        write_file(self.file, text.encode(), [file for one in self.taken for file in one.inputs])
        left = left_out(self.embedding.left) if self.embedding.left else ""
        return ChangesPage(self.file, len(entries), len(text.encode()), left)

    def _entry(self, one: Picture) -> Data:
        data = on_disk(one.shown, self.embedding if self.with_meshes else None)
        entry: Data = {"robot": data, "changes": one.changes, "notes": one.notes, "said": one.said}
        if one.before is None:
            return entry
        found = one.before.moves
        before = before_data(one.before.old, found.shapes, found.at)
        if self.with_meshes:
            self.embedding.take(before, one.before.drawn(), one.files)
            before = nameless(before)
            known = data["meshes"]
            before["meshes"] = {name: mesh for name, mesh in before["meshes"].items() if mesh != known.get(name)}
        return {**entry, "before": before, "moved": dict(found.how)}


def _removed(page: Path) -> bool:
    """Remove a page of changes that an earlier run has written: it shows what is no more. Say whether there was one."""
    try:
        if not files.is_file(page) or "changes" not in data_of(files.read_text(page)):  # an artifact is not ours
            return False
        page.unlink()
    except (OSError, ValueError):
        return False
    return True


def of_committed(
    request: Request,
    compiled: Compiled,
    comparison: Comparison,
    committed: Mapping[str, bytes],
    meshes: Sequence[tuple[str, str]],
) -> Picture | None:
    """Return the picture of what changed since artifacts were committed; ``meshes`` are those that differ.

    None for a robot that cannot be shown.
    """
    shown, description = look(request).shown, request.description
    if shown is None:
        return None
    robot = shown.robot
    before = before_of(robot, comparison.pairs) if committed else None
    changes = [change_data(one, [robot, *([before.old] if before else [])]) for one in comparison.changes]
    notes = [f"{text.file}: {text.remark}" for text in comparison.texts if text.remark]
    if not changes:
        notes += [f"{text.file}: different text" for text in comparison.texts if not text.remark]
    notes += [f"{name}: {what}" for name, what in meshes]
    files = {**shown.meshes, **{name: description.outputs / name for name in committed}}
    inputs = (*compiled.inputs, *shown.meshes.values(), *(description.outputs / name for name in committed))
    if before is None:
        return Picture(shown, None, {}, [], [], "nothing is committed to compare with", inputs)
    before = before.with_meshes(_changed_meshes(compiled, committed, meshes))
    said = f"{counted(len(changes), 'change')} against {COMMITTED}" if changes else _unchanged(notes)
    return Picture(shown, before, files, changes, notes, said, inputs)


def _unchanged(notes: Sequence[str]) -> str:
    return "no change that is compared by meaning" if notes else f"no change: this is {COMMITTED}"


def change_data(change: Change, robots: Iterable[Robot]) -> Data:
    """Return a change as the page has it, with the frame where it is to be seen."""
    _, is_colour, values = change.text.rpartition(" colour ")
    colours = _colours(*values.split(" -> ")) if is_colour and " -> " in values else None
    return _said(change.words(), _frame(change.kind, change.name, robots), change.artifacts, colours)


def _said(text: str, frame: str, artifacts: Sequence[str] = (), colours: Data | None = None) -> Data:
    made: Data = {"text": text}
    if frame:
        made["frame"] = frame
    if frame and colours:
        made["colours"] = colours
    return made | ({"artifacts": list(artifacts)} if artifacts else {})


def _colours(was: object, became: object) -> Data:
    """Return two colours as they are said, in numbers or not at all, as the page draws them."""

    def rgba(text: str) -> list[float] | None:
        numbers = text.split()
        return [float(number) for number in numbers] if len(numbers) == len(_RGBA) else None

    return {"was": rgba(str(was)), "is": rgba(str(became))}


def _frame(kind: str, name: str, robots: Iterable[Robot]) -> str:
    """Return the frame at which a change is to be seen; empty if there is none."""
    plain = name.split(" when ")[0].split(" below ")[0]  # the row of a publisher that takes turns
    for robot in robots:
        if kind == "joint" and name in robot.joint:
            return robot.joint[name].child
        sensor = next((one for one in robot.sensors if one.name == name), None)
        if kind == "sensor" and sensor is not None:
            return sensor.frame
        if plain in robot.link:
            return plain
        joints = next((group.joints for group in robot.servos if group.name == name), ())
        if joints and joints[0] in robot.joint:
            return robot.joint[joints[0]].child
    return ""


def _changed_meshes(
    compiled: Compiled, committed: Mapping[str, bytes], meshes: Sequence[tuple[str, str]]
) -> frozenset[str]:
    """Return the meshes, as the description names them, whose committed files are others."""
    other = {name for name, _ in meshes if name in committed}
    found = compiled.meshes.found if compiled.meshes else ()
    return frozenset(one.named.name for one in found if other.intersection(one.places))


def of_sides(shown: Sequence[Shown], difference: Difference, prefix: str | None) -> Picture:
    """Return the picture of two robots, the first under the second one; ``prefix`` is that of the second one."""
    a, b = difference.sides
    overlay = of_two(difference, prefix)
    changes = [
        _said(one.text, overlay.frames.get(one.name, ""), (), _coloured(one.quantity, one.before, one.after))
        for one in difference.items
    ]
    notes = [f"note: {note}" for note in difference.notes]
    notes += [f"not compared: {line}" for line in difference.not_compared]
    said = f"{Path(a.label).name} -> {Path(b.label).name}: {difference.summary()}"
    inputs = tuple(file for one in shown for file in (*one.files, *one.meshes.values()))
    return Picture(shown[1], overlay, shown[0].meshes, changes, notes, said, inputs)


def _coloured(quantity: str, before: object, after: object) -> Data | None:
    return _colours(before, after) if quantity == "colour" else None
