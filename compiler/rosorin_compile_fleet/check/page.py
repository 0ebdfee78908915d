"""The page of a fleet: the viewer with a robot of the middle, beside it the histograms of the numbers that differ."""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from rosorin_compile.diagnostics import ERROR, NOTE, Console, Diagnostic, counted
from rosorin_compile.extending import Description, Given, WrongUsage, world

from .columns import recognised
from .report import page_rows

if TYPE_CHECKING:
    from .command import Fleet
    from .sweep_file import Variant

_MOST = 300  # lines of one kind
_MOST_ROWS = 400


def write(fleet: Fleet, diagnostics: Sequence[Diagnostic], options: argparse.Namespace, console: Console) -> None:
    """Write the page of a fleet. Raises WrongUsage if it cannot be written."""
    from rosorin_compile.extending import OutputError, write_file

    file = Path(options.html)
    variant = _typical(fleet)
    page = _page(fleet, variant, options) if variant is not None else None
    if variant is None or page is None:
        console.warn(f"{file}: no page, because there is no robot that can be shown")
        return
    links = {link["name"] for link in page.data["links"]}
    joints = {joint["name"]: joint["child"] for joint in page.data["joints"]}
    numbers = [_placed(row, links, joints) for row in page_rows(fleet.rows[:_MOST_ROWS])]
    said = {
        "said": _sent(fleet, f"{fleet.summary()}; shown is {variant.name}"),
        "numbers": numbers,
        "lines": fleet.numbers(full=False)[-1:],
        "problems": [_line(fleet, one) for one in diagnostics if one.severity != NOTE][:_MOST],
        "notes": [_line(fleet, one) for one in diagnostics if one.severity == NOTE][:_MOST],
    }
    text = page.html(fleet=said)
    try:
        write_file(
            file,
            text.encode(errors="replace"),
            [fleet.file.path, *page.files],
        )
    except OutputError as problem:
        raise WrongUsage(f"cannot write the page: {problem.diagnostic.message}") from None
    if page.left:
        console.warn(f"{file}: without {page.left}")
    console.say(f"{file}: a page of {counted(fleet.made, 'robot')}, {len(text) / 1e6:.1f} MB")


def _placed(said: dict[str, Any], links: set[str], joints: dict[str, str]) -> dict[str, Any]:
    """Return a number whose frame is one that the page can show, or without one."""
    frame = said.pop("frame", "")
    frame = frame if frame in links else joints.get(frame, "")
    return {**said, "frame": frame} if frame else said


def _sent(fleet: Fleet, text: str) -> str:
    """Return a text without the folder on this machine, for a page that is sent."""
    folder = fleet.file.path.parent
    return text.replace(f"{folder}/", "") if folder.is_absolute() else text


def _line(fleet: Fleet, one: Diagnostic) -> dict[str, str]:
    more = [one.help, *(related.message for related in one.related)]
    made = {"text": _sent(fleet, one.message), "severity": "error" if one.severity == ERROR else one.severity}
    more = [text for text in more if text]
    return {**made, "more": "; ".join(more)} if more else made


def _typical(fleet: Fleet) -> Variant | None:
    """Return the robot whose numbers are nearest to the medians, or the first one that was made."""
    drawn = fleet.columns.drawn
    apart = [0.0] * len(drawn)
    for row in fleet.rows:
        width = row.spread.width or max(row.spread.usual[1] - row.spread.usual[0], 1e-9)
        for at, value in enumerate(row.lined_up()[: len(drawn)]):
            step = abs(value - row.spread.median) / width
            apart[at] += min(step, 10.0) if math.isfinite(step) else 10.0
    best = fleet.columns.robots[drawn[min(range(len(drawn)), key=apart.__getitem__)]] if drawn else ""
    return next((one for one in fleet.file.variants() if one.made and one.name == best), None)


def _page(fleet: Fleet, variant: Variant, options: argparse.Namespace) -> Any | None:
    """Return the page of a robot: from its description with its arguments, or else from one of its artifacts."""
    from rosorin_compile.extending import LoadError, service

    page_of = service("the page of a robot")
    paths = [Path(fleet.file.head.description)] if fleet.file.head.description else []
    paths = [fleet.file.path.parent / path for path in paths]
    given = Given(cast("dict[str, str]", {**fleet.file.head.arguments, **variant.arguments}), ())
    tried = [
        (Description(variant.name, path, variant.folder), given) for path in paths if world.kind(path) == world.FILE
    ]
    tried += [(Description(variant.name, path, variant.folder), Given({}, ())) for path in _readable(variant)]
    for description, arguments in tried:
        try:
            page = page_of(arguments, description, options)
        except LoadError:
            continue
        if page is not None:
            return page
    return None


def _readable(variant: Variant) -> list[Path]:
    """Return the artifacts of a robot that can be read as one, those that say most first."""
    found = []
    for name in variant.artifacts:
        path = variant.folder / name
        try:
            format, facts = recognised(name, world.text(path))
        except (OSError, ValueError):
            continue
        if format is not None and format.read is not None:
            found.append((len(facts), path))
    return [path for _, path in sorted(found, key=lambda one: -one[0])]
