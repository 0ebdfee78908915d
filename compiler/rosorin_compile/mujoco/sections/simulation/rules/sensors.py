"""Whether sensors of MuJoCo have what their kind measures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.rules.case import Case
from rosorin_compile.rules.simulated import BALL, several
from rosorin_compile.source.diagnostics import Diagnostic, listed
from rosorin_compile.source.rule_registry import Heading, rule
from rosorin_compile.source.tree import Path


@rule(
    "sensor-measures",
    "A sensor of `mjcf_sensors` lacks what its kind measures, or has what another kind measures.",
    "As the message says.",
    Heading.SIMULATED,
)
def sensors(case: Case) -> Iterator[Diagnostic]:
    """Sensors that MuJoCo would not build."""
    turning = several(case)
    for name, entry in (case.tree.get("mjcf_sensors") or {}).items():
        path: Path = ("mjcf_sensors", name)
        kind = entry["kind"]
        known = MEASURES[kind]
        needed = known.needs
        for key in entry:
            if key not in known.words:
                message = f'sensor "{name}" is of kind {kind}, which has no {key}'
                takes = [word for word in (*known.ends, *known.more) if word not in entry]
                help = f"leave it out; it may have {', '.join(takes)}" if takes else "leave it out"
                yield case.problem("sensor-measures", message, (*path, key), help, key=True)
        for choice in needed:
            said = [word for word in choice if word in entry]
            if len(said) != 1:
                what = f"says {listed(said)} at once" if said else f"does not say its {' or '.join(choice)}"
                help = "leave one of them out" if said else f"write {choice[0]}: ..."
                message = f'sensor "{name}" is of kind {kind} and {what}'
                yield case.problem("sensor-measures", message, path, help, key=True)
        joint = entry.get("joint")
        if joint is not None and "joint" in known.words and (turning.get(joint) == BALL) != kind.startswith("ball"):
            what = f"is {turning[joint]}" if joint in turning else "is no ball"
            message = f'sensor "{name}" is of kind {kind}, and joint "{joint}" {what}'
            yield case.problem("sensor-measures", message, (*path, "joint"), "take another kind, or another joint")
        for key in ("object", "reference"):
            if key in entry and len(entry[key]) != 1:
                message = f'the {key} of sensor "{name}" is {len(entry[key])} things'
                help = "write one: {link: NAME}, {site: NAME}, {shape: NAME} or {camera: NAME}"
                yield case.problem("sensor-measures", message, (*path, key), help, key=True)


class Measure(NamedTuple):
    """What a kind of sensors needs, one of each choice, and what else it may have."""

    needs: tuple[tuple[str, ...], ...] = ()
    more: tuple[str, ...] = ()
    noise: bool = True

    @property
    def ends(self) -> list[str]:
        """All words that say what it measures."""
        return [word for choice in self.needs for word in choice]

    @property
    def words(self) -> set[str]:
        """The keys that it may have."""
        timed = ("nsample", "interp", "interval", "delay", "noise") if self.noise else ()
        return {"kind", "cutoff", "user", "source", *self.ends, *self.more, *timed}


def _each(kinds: str, *needs: tuple[str, ...], more: tuple[str, ...] = ()) -> dict[str, Measure]:
    return {kind: Measure(needs, more) for kind in kinds.split()}


_BOTH = ("link1", "link2", "shape1", "shape2", "subtree1", "subtree2")
_BETWEEN = (("link1", "shape1"), ("link2", "shape2"))
MEASURES: Mapping[str, Measure] = {
    **_each("touch accelerometer velocimeter gyro force torque magnetometer", ("site",)),
    **_each("camprojection", ("site",), ("camera",)),
    **_each("rangefinder", ("site", "camera"), more=("data",)),
    **_each("jointpos jointvel jointactuatorfrc ballquat ballangvel", ("joint",)),
    **_each("jointlimitpos jointlimitvel jointlimitfrc", ("joint",)),
    **_each("tendonpos tendonvel tendonactuatorfrc tendonlimitpos tendonlimitvel tendonlimitfrc", ("tendon",)),
    **_each("actuatorpos actuatorvel actuatorfrc", ("actuator",)),
    **_each("framepos framequat framexaxis frameyaxis framezaxis", ("object",), more=("reference",)),
    **_each("framelinvel frameangvel", ("object",), more=("reference",)),
    **_each("framelinacc frameangacc", ("object",)),
    **_each("subtreecom subtreelinvel subtreeangmom", ("link",)),
    **_each("insidesite", ("site",), ("object",)),
    **_each("distance normal fromto", *_BETWEEN),
    **_each("contact", more=("site", "num", "data", "reduce", *_BOTH)),
    **_each("e_potential e_kinetic clock"),
    "tactile": Measure((("shape",), ("mesh",)), ("nsample", "interp", "delay", "interval"), noise=False),
    "user": Measure((("dim",),), ("object", "datatype", "needstage", "noise"), noise=False),
}
"""What each kind of sensors measures."""
