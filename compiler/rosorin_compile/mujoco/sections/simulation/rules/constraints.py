"""Whether constraints have the ends that their type holds together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rosorin_compile.rules.case import Case
from rosorin_compile.rules.simulated import several
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path


@rule(
    "constraint-ends",
    "A constraint lacks what its type holds together, or has what another type holds: `connect` takes two links and a "
    "point `at`, or two sites; `weld` two links or two sites; `joint` joints.",
    "As the message says.",
    Heading.SIMULATED,
)
def constraints(case: Case) -> Iterator[Diagnostic]:
    """Constraints that MuJoCo would not build."""
    section, turning = case.tree.get("constraints") or {}, several(case)
    for name, entry in section.items():
        for index, joint in enumerate(entry.get("joints") or ()):
            if joint in turning:
                message = f'constraint "{name}" holds joint "{joint}", which is {turning[joint]}'
                help = "name joints with one position each"
                yield case.problem("constraint-ends", message, ("constraints", name, "joints", index), help)
        path: Path = ("constraints", name)
        wrong = _constraint(entry)
        if wrong:
            message, help, *key = wrong
            place = (*path, *key)
            yield case.problem("constraint-ends", f'constraint "{name}" {message}', place, help, key=True)


_ENDS = {"connect": ("links", "sites"), "weld": ("links", "sites"), "joint": ("joints",)}
_MORE = {
    "connect": ("at",),
    "weld": ("at", "xyz", "rpy", "torque_scale"),
    "joint": ("polynomial",),
}


def _constraint(entry: Mapping[str, object]) -> tuple[str, ...] | None:
    """Return what is wrong with a constraint, the fix, and the key that is about it."""
    kind = str(entry["type"])
    legal = (*_ENDS[kind], *_MORE[kind], "type", "active", "solref", "solimp", "source")
    extra = next((key for key in entry if key not in legal), "")
    if extra:
        return f"is of type {kind}, which has no {extra}", "leave it out, or correct the type", extra
    ends = [key for key in _ENDS[kind] if key in entry]
    if len(ends) != 1:
        if ends:
            return "has links and sites", "leave one of them out", "sites"
        return f"is of type {kind} and holds nothing", f"write {' or '.join(f'{end}: [...]' for end in _ENDS[kind])}"
    fixed = next((key for key in ("at", "xyz", "rpy") if key in entry and ends == ["sites"]), "")
    if fixed:
        return f"holds sites where they are, and has {fixed}", "leave it out", fixed
    if kind == "connect" and ends == ["links"] and "at" not in entry:
        return "connects links and does not say where", "write at: [X, Y, Z] in the first link"
    held = entry[ends[0]]
    if isinstance(held, list) and len(held) == 2 and held[0] == held[1]:
        return f'holds "{held[0]}" to itself', "name two", ends[0]
    return None
