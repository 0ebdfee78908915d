"""Materials: one meaning each, and a name that means something."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rosorin_compile.model.shape import Material, Rgba
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, nearest
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import quoted

from .case import Case, number

MAX_RELATED = 3


class _Defined(NamedTuple):
    material: Material
    path: Path


@rule(
    "material-twice",
    "A material has two looks: in `materials` and in a visual, or in two visuals.",
    "Give one of them another name.",
    NUMBERS,
)
def once(case: Case) -> Iterator[Diagnostic]:
    """Materials of one name that look different in two places: readers of URDF take one of them for all."""
    first: dict[str, _Defined] = {}
    for defined in _definitions(case):
        name = defined.material.name
        taken = first.setdefault(name, defined)
        if taken.material == defined.material:
            continue
        message = f'the material "{name}" is {_look(defined.material)} here and {_look(taken.material)} elsewhere'
        related = [case.related("the other one", taken.path)]
        help = "give one of them another name; a name has one meaning in the whole URDF"
        yield case.problem("material-twice", message, defined.path, help, related=related)


# A hundredth above one is rounding of a colour that was made by hand.
BRIGHTEST = 1.01


@rule(
    "colour-range",
    "A warning: a part of a colour is below 0 or above 1.",
    "Divide values of 0 to 255 by 255.",
    NUMBERS,
    accept="link",
    imported="always",
)
def colours(case: Case) -> Iterator[Diagnostic]:
    """Colours that no reader shows as they are written."""
    for what, rgba, path in _colours(case):
        index = max(range(4), key=lambda one: abs(rgba[one] - 0.5))
        if 0 <= rgba[index] <= BRIGHTEST:
            continue
        message = f"{what} has {number(rgba[index])} in its rgba: each is from 0 to 1"
        help = "divide what counts to 255 by 255" if rgba[index] > 1 else "correct it"
        yield case.problem("colour-range", message, (*path, "rgba", index), help, severity=WARNING)


def _colours(case: Case) -> Iterator[tuple[str, Rgba, Path]]:
    """Yield each colour, whose it is, and the path of the entry that has it."""
    for material in case.robot.materials:
        if material.rgba is not None:
            yield f'the material "{material.name}"', material.rgba, ("materials", material.name)
    for link in case.robot.links:
        for index, visual in enumerate(link.visual):
            if visual.rgba is not None:
                yield f'a visual of link "{link.name}"', visual.rgba, case.link(link.name, "visual", index)


@rule(
    "unknown-material",
    "A note: a visual is of a material that nothing describes. As a warning: its name is nearly that of one that is "
    "described.",
    "Correct the name, or add it to `materials`, if readers do not know it.",
    NUMBERS,
)
def unknown_materials(case: Case) -> Iterator[Diagnostic]:
    """Names of materials that nothing says the look of: legal, but seldom meant."""
    unknown: dict[str, list[Path]] = {}
    described = case.robot.material
    for link in case.robot.links:
        for index, visual in enumerate(link.visual):
            if visual.material and visual.material not in described:
                unknown.setdefault(visual.material, []).append(case.link(link.name, "visual", index, "material"))
    for name in list(unknown):
        close = nearest(name, described)
        if close:
            path, *others = unknown.pop(name)
            related = [case.related("also of it", other) for other in others[:MAX_RELATED]]
            message, help = f'there is no material "{name}"', f'did you mean "{close}"?'
            yield case.problem("unknown-material", message, path, help, related=related, severity=WARNING)
    if unknown:
        names = list(unknown)
        what = (
            "a material that nothing describes" if len(names) == 1 else f"{len(names)} materials that nothing describes"
        )
        message = f"visuals are of {what}: {quoted(names, 8)}"
        help = "add materials: {NAME: {rgba: [...]}} where readers do not know them"
        yield case.problem("unknown-material", message, unknown[names[0]][0], help, severity=NOTE)


def _definitions(case: Case) -> Iterator[_Defined]:
    for material in case.robot.materials:
        if material.rgba is not None or material.texture:
            yield _Defined(material, ("materials", material.name))
    for link in case.robot.links:
        for index, visual in enumerate(link.visual):
            if visual.material and (visual.rgba is not None or visual.texture):
                path = case.link(link.name, "visual", index, "material")
                yield _Defined(Material(visual.material, visual.rgba, visual.texture), path)


def _look(material: Material) -> str:
    colour = f"rgba [{', '.join(map(number, material.rgba))}]" if material.rgba is not None else ""
    return " with ".join(filter(None, [colour, material.texture and f'texture "{material.texture}"']))
