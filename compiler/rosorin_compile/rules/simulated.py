"""Simulation: whether actuators, tendons, constraints and sensors have what MuJoCo needs of them, and no more.

``simulated_names`` says whether what they name is there, ``simulated_values`` whether their numbers are in order.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

from ..diagnostics import Diagnostic
from ..diagnostics.registry import SIMULATED, rule
from ..diagnostics.wording import listed
from ..frontend.tree import Path
from ..model import Cylinder, Joint, Sphere
from ..model.simulation import Actuator
from ..sections.simulation import ACTUATORS, TENDONS
from ..sections.simulation.lowering import TARGETS
from .case import Case, number
from .simulated_names import BALL, several
from .unfit import unfit

AFTER = "simulated_names"


def _set(words: str) -> frozenset[str]:
    return frozenset(words.split())


# Words of all actuators, and of those that drive by a transmission.
_ALL = _set("name group nsample interp delay ctrlrange user")
_DRIVEN = _ALL | _set(
    "ctrllimited forcelimited forcerange lengthrange gear damping armature cranklength joint jointinparent tendon"
    " slidersite cranksite site refsite"
)
_GENERAL = "actlimited actrange actdim input velrange ffrange inheritrange dyntype gaintype biastype dynprm gainprm"


def _and(words: str, without: str = "") -> frozenset[str]:
    return (_DRIVEN | _set(words)) - _set(without)


WORDS: Mapping[str, frozenset[str]] = {
    "general": _and(f"body biasprm actearly {_GENERAL}"),
    "motor": _DRIVEN,
    "position": _and("inheritrange kp kv dampratio timeconst"),
    "velocity": _and("kv"),
    "intvelocity": _and("actlimited actrange inheritrange kp kv dampratio"),
    "orientation": _ALL | _set("forcelimited forcerange joint site refsite kp kv dampratio input"),
    "pid": _and("posrange velrange ffrange inheritrange kp kv dampratio ki imax slewmax input"),
    "damper": _and("kv", "ctrllimited"),
    "cylinder": _and("timeconst area diameter bias"),
    "muscle": _and("timeconst tausmooth range force scale lmin lmax vmax fpmax fvmax", "site refsite"),
    "adhesion": _ALL | _set("forcelimited forcerange body gain"),
    "dcmotor": _and(
        "motorconst resistance nominal saturation inductance cogging controller thermal lugre input",
        "forcelimited forcerange",
    ),
}
"""The attributes that MuJoCo knows of each type of actuators."""

_OF_US = {"kp": "kp", "kv": "kv", "dampratio": "damping_ratio", "gear": "gear", "forcerange": "force"}
_LACKING = {"position": "kp", "velocity": "kv", "damper": "kv", "intvelocity": "kp", "orientation": "kp", "pid": "kp"}


class Driver(NamedTuple):
    """An actuator, what it is called in a message, its path, and the joint that it stands with."""

    actuator: Actuator
    called: str
    path: Path
    joint: Joint | None


def drivers(case: Case) -> Iterator[Driver]:
    """Yield every actuator of a robot: those of joints that move, and those of the section."""
    for joint in case.robot.joints:
        if joint.actuator is not None and joint.moves:
            yield Driver(joint.actuator, f'the actuator of joint "{joint.name}"', case.joint(joint, "actuator"), joint)
    for actuator in case.robot.sections[ACTUATORS]:
        yield Driver(actuator, f'actuator "{actuator.name}"', ("actuators", actuator.name), None)


@rule(
    "actuator-target",
    "An actuator acts on nothing, on two things, or on what its type cannot drive.",
    "Name one: a joint, a tendon, a site or a body.",
    SIMULATED,
)
def targets(case: Case) -> Iterator[Diagnostic]:
    """Actuators of the section that do not act on one thing."""
    for actuator in case.robot.sections[ACTUATORS]:
        path: Path = ("actuators", actuator.name)
        wrong = _target(actuator, several(case))
        if wrong:
            message, help = wrong
            yield case.problem("actuator-target", f'actuator "{actuator.name}" {message}', path, help, key=True)


def _target(actuator: Actuator, turning: Mapping[str, str]) -> tuple[str, str] | None:
    """Return what is wrong with what an actuator acts on, and the way out."""
    given, words = set(actuator.targets), {word: key for key, word in TARGETS.items()}
    if not given:
        return "acts on nothing", "name one: joint: NAME, tendon: NAME, site: NAME or body: NAME"
    needs = {"refsite": "site", "slidersite": "cranksite", "cranksite": "slidersite"}
    for word, other in needs.items():
        if word in given and other not in given:
            return f"has a {words[word]} and no {words[other]}", f"add {words[other]}: NAME"
    kinds = given - {"refsite", "slidersite"}
    if len(kinds) > 1:
        named = listed([words[word] for word in sorted(given)])
        return f"acts on several things: {named}", "leave one; write an actuator for each of the others"
    known = WORDS[actuator.type]
    if not given <= known:
        can = [word for word in TARGETS if TARGETS[word] in known]
        way = f"name a {' or '.join(can)}" if can else ""
        return f"is of type {actuator.type}, which drives no {words[min(given - known)]}", way
    if actuator.type == "orientation" and given == {"site"}:
        return "turns a site against nothing", "add reference_site: NAME"
    if actuator.type == "orientation" and "joint" in given and not given & {"site"}:
        return _ball(actuator, turning)
    if "cranksite" in given and not (_number(actuator, "cranklength") or 0.0) > 0:
        return "has a crank without a length", "write mjcf: {cranklength: ...}, in m"
    return None


def _ball(actuator: Actuator, turning: Mapping[str, str]) -> tuple[str, str] | None:
    name = actuator.targets["joint"]
    if turning.get(name) == BALL:
        return None
    return f'turns joint "{name}", which is no ball', "name a ball joint, or a site"


def _number(actuator: Actuator, word: str) -> float | None:
    value = actuator.mjcf.get(word)
    return float(value) if isinstance(value, (int, float)) else None


@rule(
    "actuator-word",
    "An actuator has a word that its type does not know, or lacks one that it needs: `position` needs `kp`, `velocity` "
    "needs `kv`.",
    "As the message says.",
    SIMULATED,
)
def words(case: Case) -> Iterator[Diagnostic]:
    """Actuators with words of another type, or without one that a simulation would invent."""
    for driver in drivers(case):
        actuator, called, path, joint = driver
        known = WORDS[actuator.type]
        for word, key in _said(actuator):
            if word not in known:
                others = [kind for kind in WORDS if word in WORDS[kind]]
                message = f"{called} is of type {actuator.type}, which has no {key[-1]}"
                help = f"leave it out, or take a type that has it: {', '.join(others)}"
                yield case.problem("actuator-word", message, (*path, *key), help, key=True)
        if joint is not None and not known & {"joint"}:
            message = f"{called} is of type {actuator.type}, which drives no joint"
            yield case.problem("actuator-target", message, (*path, "type"), "write it under actuators, with its target")
        yield from _lacking(case, driver)


def _said(actuator: Actuator) -> Iterator[tuple[str, Path]]:
    """Yield the words of MuJoCo that an actuator says, and the keys that say them."""
    values: dict[str, object] = {"kp": actuator.kp is not None, "kv": actuator.kv, "dampratio": actuator.damping_ratio}
    values |= {"gear": actuator.gear, "forcerange": actuator.force is not None}
    yield from ((word, (_OF_US[word],)) for word, said in values.items() if said)
    yield from ((word, ("mjcf", word)) for word in actuator.mjcf)


def _lacking(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    actuator, called, path, _ = driver
    kind = actuator.type
    word = _LACKING.get(kind, "")
    said = {"kp": actuator.kp is not None, "kv": bool(actuator.kv)}
    if word and not said[word]:
        message = f"{called} is of type {kind} and has no {word}: MuJoCo would take 1"
        yield case.problem("actuator-word", message, path, f"write {word}: ...", key=True)
    if actuator.damping_ratio and said["kv"]:
        message = f"{called} has kv and damping_ratio, two words for one damping"
        yield case.problem("actuator-word", message, (*path, "damping_ratio"), "leave one of them out", key=True)
    if "inheritrange" in actuator.mjcf:
        yield from _inherited(case, driver)
    elif kind in ("damper", "adhesion") and (actuator.range is None or actuator.unlimited):
        message = f"{called} is of type {kind} and has no range"
        place = (*path, "unlimited") if actuator.unlimited else path
        yield case.problem("actuator-word", message, place, "write range: [0, ...]", key=True)
    elif kind in ("damper", "adhesion") and actuator.range is not None and actuator.range[0] < 0:
        message = f"the range of {called} begins below zero, and it is of type {kind}"
        yield case.problem("actuator-word", message, (*path, "range"), "write range: [0, ...]")
    if kind == "dcmotor":
        yield from _motor(case, driver)
    if kind == "muscle" and actuator.gear and not actuator.gear[0] and "lengthrange" not in actuator.mjcf:
        message = f"{called} is of type muscle and has a gear of 0: its length never changes"
        help = "write another gear, or mjcf: {lengthrange: [..., ...]}"
        yield case.problem("actuator-word", message, (*path, "gear"), help, key=True)
    yield from _limited(case, driver)
    for word, message, help in unfit(actuator):
        yield case.problem("actuator-word", f"{called} {message}", (*path, "mjcf", word), help, key=True)


def _motor(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what a motor lacks of its constants."""
    values = driver.actuator.mjcf
    constants, nominal, resistance = (values.get(word) for word in ("motorconst", "nominal", "resistance"))
    if isinstance(nominal, tuple) and len(nominal) == 3 and all(float(value) > 0 for value in nominal):
        return
    turns = isinstance(constants, tuple) and all(float(one) >= 0 for one in constants) and any(constants)
    if not turns or not isinstance(resistance, float) or not resistance > 0:
        message = f"{driver.called} is of type dcmotor and lacks the constant or the resistance of its motor"
        help = "write mjcf: {motorconst: [...], resistance: ...}, or nominal: [VOLTAGE, STALL_TORQUE, NO_LOAD_SPEED]"
        yield case.problem("actuator-word", message, driver.path, help, key=True)


_LIMITED = {"ctrllimited": "range", "forcelimited": "force", "actlimited": "actrange"}


def _limited(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what says that a range holds, or a delay, and has none."""
    actuator, called, path, joint = driver
    has = {
        "range": actuator.range is not None or "posrange" in actuator.mjcf or "inheritrange" in actuator.mjcf
        or (joint is not None and not actuator.unlimited and joint.limit is not None),
        "force": actuator.force is not None,
        "actrange": "actrange" in actuator.mjcf or "inheritrange" in actuator.mjcf,
    }  # fmt: skip
    for word, other in _LIMITED.items():
        if actuator.mjcf.get(word) is True and not has[other]:
            message = f"{called} is {word} and has no {other}"
            yield case.problem("actuator-word", message, (*path, "mjcf", word), f"write {other}: [..., ...]", key=True)
    if (_number(actuator, "delay") or 0.0) > 0 and not (_number(actuator, "nsample") or 0.0) > 0:
        message = f"{called} has a delay and no samples to take it from"
        yield case.problem("actuator-word", message, (*path, "mjcf", "delay"), "write nsample: 2, or more", key=True)


def _inherited(case: Case, driver: Driver) -> Iterator[Diagnostic]:
    """Yield what keeps an actuator from the range of what it drives."""
    actuator, called, path, joint = driver
    place = (*path, "mjcf", "inheritrange")
    kinds = set(actuator.targets) or {"joint"}
    other = "range" if actuator.range is not None else "actrange" if "actrange" in actuator.mjcf else ""
    tendon = next((one for one in case.robot.sections[TENDONS] if one.name == actuator.targets.get("tendon")), None)
    target = joint or case.robot.joint.get(actuator.targets.get("joint", ""))
    limit = target.limit if target is not None and target.type != "continuous" else None
    has = limit is not None and limit.lower is not None and limit.upper is not None
    has = has or (tendon is not None and "range" in tendon.values)
    if other:
        message = f"{called} has {other} and inheritrange, two words for one range"
        yield case.problem("actuator-word", message, place, "leave one of them out", key=True)
    elif not kinds <= {"joint", "tendon"} or not has:
        message = f"{called} takes over a range, but what it drives has none"
        yield case.problem("actuator-word", message, place, "write range: [..., ...]", key=True)


@rule(
    "tendon-path",
    "A tendon has neither joints nor a path, or both, or its path is none: less than two sites, a stop that is two "
    "things, a shape or a pulley where MuJoCo takes none.",
    "As the message says.",
    SIMULATED,
)
def tendons(case: Case) -> Iterator[Diagnostic]:
    """Tendons that MuJoCo would not build."""
    section, turning = case.tree.get("tendons") or {}, several(case)
    for tendon in case.robot.sections[TENDONS]:
        path: Path = ("tendons", tendon.name)
        called = f'tendon "{tendon.name}"'
        if bool(tendon.joints) == bool(tendon.path):
            what = "joints and a path" if tendon.joints else "neither joints nor a path"
            help = "leave one of them out" if tendon.joints else "write joints: {NAME: 1}, or path: [{site: NAME}, ...]"
            yield case.problem("tendon-path", f"{called} has {what}", path, help, key=True)
            continue
        for joint in tendon.joints:
            if joint in turning:
                message = f'{called} goes along joint "{joint}", which is {turning[joint]} and has no single position'
                yield case.problem("tendon-path", message, (*path, "joints", joint), "name a joint with one", key=True)
        yield from _springs(case, called, path, section[tendon.name])
        drawn = [word for word in ("width", "rgba", "material") if tendon.joints and word in section[tendon.name]]
        for word in drawn:
            message = f"{called} goes along joints and is not drawn: it has no {word}"
            yield case.problem("tendon-path", message, (*path, word), "leave it out", key=True)
        yield from _path(case, called, path, section[tendon.name].get("path") or ())


def _springs(case: Case, called: str, path: Path, entry: Mapping[str, Any]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the lengths of a tendon."""
    lengths: list[float] = entry.get("spring_length") or []
    if len(lengths) == 2 and lengths[0] > lengths[1]:
        message = f"the spring_length of {called} goes from {number(lengths[0])} to {number(lengths[1])}"
        yield case.problem("tendon-path", message, (*path, "spring_length"), "give the smaller length first")
    if (entry.get("mjcf") or {}).get("limited") is True and "range" not in entry:
        message = f"{called} is limited and has no range"
        yield case.problem("tendon-path", message, (*path, "mjcf", "limited"), "write range: [..., ...]", key=True)
    if (entry.get("mjcf") or {}).get("actuatorfrclimited") is True and "force" not in entry:
        message = f"the force of {called} is limited and has no range"
        place = (*path, "mjcf", "actuatorfrclimited")
        yield case.problem("tendon-path", message, place, "write force: [..., ...]", key=True)
    wraps = [index for index, stop in enumerate(entry.get("path") or ()) if "shape" in stop]
    if wraps and entry.get("armature"):
        message = f"{called} goes around a shape and has an armature, which MuJoCo does not take together"
        yield case.problem("tendon-path", message, (*path, "armature"), "leave it out", key=True)
    for index in wraps:
        name = entry["path"][index]["shape"]
        if not _is_round(case, name):
            message = f'{called} goes around "{name}", which is no sphere and no cylinder'
            yield case.problem("tendon-path", message, (*path, "path", index, "shape"), "name a shape that is round")


def _is_round(case: Case, name: str) -> bool:
    """Say whether a tendon goes around a shape; one that nobody knows here is known to elements of MJCF."""
    for link in case.robot.links:
        for purpose in ("collision", "visual"):
            solids = [solid for shape in getattr(link, purpose) for solid in shape.solids()]
            for index, solid in enumerate(solids, start=1):
                if name in (solid.name, f"{link.name}_{purpose}_{index}"):
                    return isinstance(solid.geometry, (Sphere, Cylinder))
    return True


def _path(case: Case, called: str, path: Path, stops: Sequence[Mapping[str, object]]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the path of a tendon: each branch runs from a site to a site."""
    kinds: list[str] = []
    for index, stop in enumerate(stops):
        said = [word for word in ("site", "shape", "pulley") if word in stop]
        at = (*path, "path", index)
        if len(said) != 1:
            what = f"is {listed(said)}" if said else "says nothing"
            help = "write one of them: {site: NAME}, {shape: NAME} or {pulley: 2}"
            yield case.problem("tendon-path", f"a stop of {called} {what}", at, help)
            return
        if said == ["pulley"] and not float(str(stop["pulley"])) > 0:
            message = f"a pulley of {called} divides by {stop['pulley']}"
            yield case.problem("tendon-path", message, (*at, "pulley"), "write a number above zero")
        if "side_site" in stop and said != ["shape"]:
            message = f"a stop of {called} has a side_site and no shape"
            yield case.problem("tendon-path", message, (*at, "side_site"), "name the shape that it goes around")
        kinds += said
    branches = " ".join(kinds).split("pulley")
    for branch in branches:
        words = branch.split()
        help = "begin and end at a site, and pass one between two shapes"
        if len(words) < 2 and kinds:
            message = f"{called} has a branch of {len(words)} stops" if len(branches) > 1 else f"{called} has one stop"
            yield case.problem("tendon-path", message, (*path, "path"), "write at least two sites", key=True)
            return
        same = [one for one, other in pairwise(stops) if "site" in one and one.get("site") == other.get("site")]
        if same:
            message = f'{called} passes the site "{same[0]["site"]}" twice in succession'
            yield case.problem("tendon-path", message, (*path, "path"), "leave one of them out", key=True)
            return
        shapes = [n for n, word in enumerate(words) if word == "shape"]
        if any(n in (0, len(words) - 1) or words[n + 1] == "shape" for n in shapes):
            message = f"{called} goes around a shape that has no site before it and behind it"
            yield case.problem("tendon-path", message, (*path, "path"), help, key=True)
            return


@rule(
    "constraint-ends",
    "A constraint lacks what its type holds together, or has what another type holds: `connect` takes two links and a "
    "point `at`, or two sites; `weld` two links or two sites; `joint` joints; `tendon` tendons.",
    "As the message says.",
    SIMULATED,
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


_ENDS = {"connect": ("links", "sites"), "weld": ("links", "sites"), "joint": ("joints",), "tendon": ("tendons",)}
_MORE = {
    "connect": ("at",),
    "weld": ("at", "xyz", "rpy", "torque_scale"),
    "joint": ("polynomial",),
    "tendon": ("polynomial",),
}


def _constraint(entry: Mapping[str, object]) -> tuple[str, ...] | None:
    """Return what is wrong with a constraint, the way out, and the key that is about it."""
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


@rule(
    "sensor-measures",
    "A sensor of `mjcf_sensors` lacks what its kind measures, or has what another kind measures.",
    "As the message says.",
    SIMULATED,
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
