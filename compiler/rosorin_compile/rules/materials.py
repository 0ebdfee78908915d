"""Materials: one meaning each, and a name that means something."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model import Shape
from rosorin_compile.model.shape import Material, Rgba
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, nearest
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import quoted

from .case import Case, number

BRIGHTEST = 1.01  # a hundredth above one is rounding of a colour that was made by hand
MAX_RELATED = 3


def _visuals(case: Case) -> Iterator[tuple[str, Path, Shape]]:
    for link in case.robot.links:
        for index, visual in enumerate(link.visual):
            yield f'a visual of link "{link.name}"', case.link(link.name, "visual", index), visual


@rule("material-twice", help="Give one of them another name; it has one meaning in the whole URDF.", topic=NUMBERS)
def definitions(case: Case) -> Iterator[Diagnostic]:
    """A material has two looks: in `materials` and in a visual, or in two visuals."""
    named = [one for one in case.robot.materials if one.rgba is not None or one.texture]
    defined: list[tuple[Path, Material]] = [(("materials", one.name), one) for one in named]
    defined += [
        ((*path, "material"), Material(visual.material, visual.rgba, visual.texture))
        for _, path, visual in _visuals(case)
        if visual.material and (visual.rgba is not None or visual.texture)
    ]
    first: dict[str, tuple[Path, Material]] = {}
    for path, material in defined:
        place, other = first.setdefault(material.name, (path, material))
        if other != material:
            message = f'the material "{material.name}" is {_look(material)} here and {_look(other)} elsewhere'
            yield case.problem("material-twice", message, path, related=[("the other one", place)])


def _look(material: Material) -> str:
    colour = f"rgba [{', '.join(map(number, material.rgba))}]" if material.rgba is not None else ""
    return " with ".join(filter(None, [colour, material.texture and f'texture "{material.texture}"']))


@rule("colour-range", help="Divide values of 0 to 255 by 255.", topic=NUMBERS, accept="link", imported="always")
def colour_range(case: Case) -> Iterator[Diagnostic]:
    """A warning: a part of a colour is below 0 or above 1."""
    colours: list[tuple[str, Path, Rgba | None]] = [(what, path, one.rgba) for what, path, one in _visuals(case)]
    colours += [(f'the material "{one.name}"', ("materials", one.name), one.rgba) for one in case.robot.materials]
    for what, path, rgba in colours:
        parts = rgba or (0.5,) * 4
        index = max(range(4), key=lambda part: abs(parts[part] - 0.5))
        if not 0 <= parts[index] <= BRIGHTEST:
            message = f"{what} has {number(parts[index])} in its rgba: each is from 0 to 1"
            yield case.problem("colour-range", message, (*path, "rgba", index))


@rule("unknown-material", help="Correct the name, or add it to `materials`.", topic=NUMBERS)
def unknown_materials(case: Case) -> Iterator[Diagnostic]:
    """A note: no material is defined under the name in a visual; a warning if the name is nearly a defined one."""
    unknown: dict[str, list[Path]] = {}
    for _, path, visual in _visuals(case):
        if visual.material and visual.material not in case.robot.material:
            unknown.setdefault(visual.material, []).append((*path, "material"))
    for name in list(unknown):
        close = nearest(name, case.robot.material)
        if close:
            path, *others = unknown.pop(name)
            related = [("also used here", other) for other in others[:MAX_RELATED]]
            message, help = f'there is no material "{name}"', f'did you mean "{close}"?'
            yield case.problem("unknown-material", message, path, help, related=related, severity=WARNING)
    if unknown:
        names = list(unknown)
        message = (
            f"{'a material of visuals is' if len(names) == 1 else f'{len(names)} materials of visuals are'} defined"
        )
        help = "add materials: {NAME: {rgba: [...]}} where readers do not know them"
        message += f" nowhere: {quoted(names, 8)}"
        yield case.problem("unknown-material", message, unknown[names[0]][0], help, severity=NOTE)
