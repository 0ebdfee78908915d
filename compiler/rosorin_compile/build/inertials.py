"""Building inertials: moments as they were written, or those of shapes of even density."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..model import Inertial, Mesh, Shape, inertial_of
from .shapes import ShapeProblem, build_shape
from .values import pose_of_entry


def build_inertial(entry: Mapping[str, Any], own: Mapping[str, Sequence[Shape]]) -> Inertial:
    """Return the inertial of an entry; ``own`` are the shapes of its link by purpose (collision, visual).

    Raises ShapeProblem, whose path leads to the culprit within the entry.
    """
    if "of" not in entry:
        if "density" in entry:
            raise ShapeProblem("ignored-key", "a density needs shapes to fill", ("density",), "add of: collision")
        moments = {key: float(value) for key, value in entry["inertia"].items()}
        return Inertial(float(entry["mass"]), pose_of_entry(entry), **moments)
    for key in ("inertia", "xyz", "rpy"):
        if key in entry:
            message = f"{key} is calculated from the shapes of the key of"
            raise ShapeProblem("wrong-value", message, (key,), "remove one of the two")
    if ("mass" in entry) == ("density" in entry):
        raise ShapeProblem("missing-key", "shapes have either a mass or a density", (), "give one of the two")
    key = "mass" if "mass" in entry else "density"
    if not entry[key] > 0:
        raise ShapeProblem("mass-not-positive", f"a {key} is above zero", (key,), "correct it")
    shapes = _shapes(entry["of"], own)
    return inertial_of(shapes, **{key: float(entry[key])})


def _shapes(said: Any, own: Mapping[str, Sequence[Shape]]) -> Sequence[Shape]:
    """Return the shapes that an inertial is of; each has a volume."""
    if isinstance(said, str):
        shapes = own[said]
        if not shapes:
            help = f"give the link a {said}, or list the shapes here: of: [box: {{size: [...]}}]"
            raise ShapeProblem("shape-kind", f"the link has no {said} shape to take the inertia of", ("of",), help)
        paths: list[tuple[str | int, ...]] = [("of",)] * len(shapes)
    else:
        shapes = [_shape(entry, index) for index, entry in enumerate(said)]
        paths = [("of", index) for index in range(len(shapes))]
    for shape, path in zip(shapes, paths, strict=True):
        if isinstance(shape.geometry, Mesh):
            help = "list primitive shapes of the same body: of: [box: {size: [...]}], or give the inertia"
            raise ShapeProblem("shape-kind", "the volume of a mesh is not known", path, help)
    return shapes


def _shape(entry: Mapping[str, Any], index: int) -> Shape:
    try:
        return build_shape(entry, pose_of_entry(entry), "")
    except ShapeProblem as problem:
        raise ShapeProblem(problem.rule, problem.message, ("of", index, *problem.path), problem.help) from None
