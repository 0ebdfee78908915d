"""``extract boxes``: a shape around each part, with how well it fits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.progress import Progress

from . import writing
from .fits import Fit, Tell, fits
from .measure import Measured, Ruler
from .parts import Part

# The share of the time that fitting takes, the rest is measuring: about.
_FITTING = 0.6

HEAD = ("part", "shape", "volume", "overhang", "sticks out", "overlap")


class Fitted(NamedTuple):
    """A part with shapes around it, by kind, and how well each of them fits."""

    part: Part
    fits: dict[str, Fit]
    measured: dict[str, Measured]

    @property
    def smallest(self) -> str:
        """The kind whose shape has the least volume."""
        return min(self.fits, key=lambda kind: self.fits[kind].volume)


def fit_parts(parts: Sequence[Part], digits: int, stack: int, axis: str) -> list[Fitted]:
    """Return shapes of every kind around each part, measured."""
    tells = [Progress.part("fitting", index, len(parts)) for index in range(len(parts))]
    return [_fit(part, digits, stack, axis, tell) for part, tell in zip(parts, tells, strict=True)]


def _fit(part: Part, digits: int, stack: int, axis: str, tell: Tell) -> Fitted:
    made = fits(part.triangles, digits, stack, axis, lambda share: tell(_FITTING * share))
    ruler = Ruler(part.triangles)
    measured: dict[str, Measured] = {}
    for kind, fit in made.items():
        tell(_FITTING + (1 - _FITTING) * len(measured) / len(made))
        measured[kind] = ruler.measure(fit)
    return Fitted(part, made, measured)


def table(fitted: Sequence[Fitted], kinds: Sequence[str]) -> list[str]:
    """Return the lines of a table of all shapes, for people."""
    rows = [HEAD]
    for one in fitted:
        for index, kind in enumerate(kinds):
            rows.append((one.part.name if index == 0 else "", *_row(kind, one.fits[kind], one.measured[kind])))
    widths = [max(len(row[column]) for row in rows) for column in range(len(HEAD))]
    lines = []
    for row in rows:
        first = [text.ljust(width) for text, width in zip(row[:2], widths[:2], strict=True)]
        others = [text.rjust(width) for text, width in zip(row[2:], widths[2:], strict=True)]
        lines.append("  ".join([*first, *others]).rstrip())
    return lines


def _row(kind: str, fit: Fit, measured: Measured) -> tuple[str, str, str, str, str]:
    what = kind.replace("_", " ") if kind != "stack" else f"stack of {len(fit.pieces)}"
    share = "open mesh"
    if measured.overhang is not None:
        share = f"{volume(measured.overhang)} ({100 * measured.overhang / measured.volume:.0f}%)"
    of = "" if measured.overhang is not None else " of surface"
    return what, volume(measured.volume), share, f"{measured.sticks_out * 1000:.1f} mm", _percent(measured.overlap) + of


def _percent(share: float) -> str:
    """Return a share in percent; 100 % is all of it, not nearly all."""
    return "100%" if share > 1 - 1e-6 else f"{math.floor(share * 1000) / 10:g}%"


def volume(value: float) -> str:
    """Return a volume for people."""
    return f"{value * 1e6:.1f} cm3" if value < 0.01 else f"{value * 1e3:.1f} l"


def yaml_text(fitted: Sequence[Fitted], kind: str) -> str:
    """Return a section ``links`` with a shape of one kind, or the smallest, for each part."""
    lines = ["links:"]
    for one in fitted:
        chosen = one.smallest if kind == "smallest" else kind
        meshes = ", ".join(one.part.meshes)
        note = f"{_words(one.fits[chosen])} around {meshes}"
        lines += [f"  {writing.name(one.part.name)}:", "    collision:"]
        lines += [f"      - {writing.shape(piece)}" for piece in one.fits[chosen].pieces]
        lines.append(f"    source: {writing.source('calculated', note)}")
    return "\n".join(lines) + "\n"


def _words(fit: Fit) -> str:
    if fit.kind == "box":
        return "axis-aligned box"
    return fit.kind.replace("_", " ") if fit.kind != "stack" else f"stack of {len(fit.pieces)} boxes"


def json_values(fitted: Sequence[Fitted], kinds: Sequence[str]) -> dict[str, Any]:
    """Return everything as values for JSON: metres, cubic metres, radians."""
    made: dict[str, Any] = {}
    for one in fitted:
        shapes = {
            kind: {
                "shapes": [writing.shape_values(piece) for piece in one.fits[kind].pieces],
                "volume": one.measured[kind].volume,
                "overhang_volume": one.measured[kind].overhang,
                "sticks_out": one.measured[kind].sticks_out,
                "overlap": one.measured[kind].overlap,
                "overlap_of": "surface" if one.measured[kind].overhang is None else "volume",
            }
            for kind in kinds
        }
        made[one.part.name] = {
            "meshes": list(one.part.meshes),
            "triangles": len(one.part.triangles),
            "closed": all(measured.overhang is not None for measured in one.measured.values()),
            "smallest": one.smallest,
            "shapes": shapes,
        }
    return made
