"""Unfit: attributes of actuators that MuJoCo takes of their type only with others, or with other numbers.

Found by giving MuJoCo 4.0 every word of every type: what it refuses is told here at its line.
"""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model.simulation import Actuator, Values

_INPUTS = {
    "orientation": ("expmap", "quat"),
    "pid": ("pos", "vel", "ff"),
    "dcmotor": ("pos", "vel", "ff", "voltage", "none"),
    "general": ("pos", "vel", "ff", "voltage", "pressure", "none", "expmap", "quat"),
}


_ONE_INPUT = ("pos", "vel", "pressure", "expmap")  # of a gain that is fixed or affine


def unfit(actuator: Actuator) -> Iterator[tuple[str, str, str]]:
    """Yield attributes that MuJoCo takes of its type only with others, or in another form: word, message, way out."""
    values, targets = actuator.mjcf, set(actuator.targets)
    if "cranklength" in values and "cranksite" not in targets:
        yield "cranklength", "has a cranklength and no crank", "write slider_site and crank_site, or leave it out"
    if targets and not targets & {"joint", "tendon", "jointinparent"}:
        for word in ("damping", "armature"):
            if word in values:
                yield word, f"has {word}, which only joints and tendons take", "leave it out"
    constants = values.get("timeconst")
    count = len(constants) if isinstance(constants, tuple) else 1
    if constants is not None and count != (2 if actuator.type == "muscle" else 1):
        help = "write two numbers: activation, deactivation" if actuator.type == "muscle" else "write one number"
        yield "timeconst", f"has {count} time constant{'s' if count > 1 else ''}", help
    if isinstance(constants, float) and constants < 0:
        yield "timeconst", "has a time constant below zero", "write a time"
    words = str(values.get("input", "")).split()
    legal = _INPUTS.get(actuator.type, ())
    if words != [word for word in legal if word in words]:
        yield "input", f'has an input "{" ".join(words)}"', f"write some of: {' '.join(legal)}, in this order"
    yield from _general(actuator)
    yield from _signs(actuator)
    if actuator.type == "dcmotor":
        yield from _motor(values, words)
    for word in ("ki", "slewmax") if actuator.type == "pid" and words and "pos" not in words else ():
        if any(_numbers(values, word)):
            yield word, f"has {word} and no input pos", f'write input: "{" ".join(["pos", *words])}", or leave it out'


def _general(actuator: Actuator) -> Iterator[tuple[str, str, str]]:
    values = actuator.mjcf
    if actuator.type == "general" and values.get("dyntype", "none") == "none":
        for word in ("actdim", "actrange", "actlimited"):
            if values.get(word):
                yield word, f"has {word} and no activation", "say its dyntype, or leave it out"
    if (
        "actdim" in values
        and values.get("dyntype") not in (None, "none", "user", "dcmotor", "pid")
        and values["actdim"] != 1
    ):
        yield "actdim", f"has one activation, that of {values['dyntype']}", "leave it out"
    if actuator.type == "general" and (values.get("gaintype") == "so3") != (values.get("biastype") == "so3"):
        word = "gaintype" if values.get("gaintype") == "so3" else "biastype"
        yield word, "is so3 in one of gaintype and biastype", "write both, or take the type orientation"
    smooth = values.get("tausmooth")
    if isinstance(smooth, float) and smooth < 0:
        yield "tausmooth", "is smoothed over a time below zero", "write a time"
    parts = [word for word in ("dyntype", "gaintype") if values.get(word) == "dcmotor"]
    if actuator.type == "general" and parts and values.get("actearly") is not True:
        yield parts[0], "is a dcmotor in parts", "take the type dcmotor"
    if actuator.type == "general":
        yield from _kinds(values)
    low, high = (values.get(word, other) for word, other in (("lmin", 0.5), ("lmax", 1.6)))
    if isinstance(low, float) and isinstance(high, float) and not low < 1 < high:
        yield ("lmin" if "lmin" in values else "lmax"), "has lengths that are not around 1", "write lmin < 1 < lmax"


# Numbers that may not be below zero, by type and word.
_SIZES = {
    "pid": ("slewmax",),
    "adhesion": ("gain",),
    "dcmotor": ("motorconst", "resistance", "inductance"),
}
# Numbers of a muscle that may not be zero; below zero MuJoCo takes its own.
_MUSCLE = ("scale", "vmax", "fpmax", "fvmax")


def _signs(actuator: Actuator) -> Iterator[tuple[str, str, str]]:
    """Yield numbers that are below zero, or zero, where MuJoCo takes none that is."""
    values = actuator.mjcf
    sizes = _SIZES.get(actuator.type, ())
    if actuator.type == "pid" and any(_numbers(values, "ki")):
        sizes = (*sizes, "imax") if any(_numbers(values, "slewmax")) else (*sizes, "ki", "imax")
    for word in sizes:
        if min(_numbers(values, word), default=0) < 0:
            yield word, f"has {word} below zero", "write it without the sign"
    for word in _MUSCLE if actuator.type == "muscle" else ():
        if 0 in _numbers(values, word):
            yield word, f"has {word} zero", "write a number above zero, or leave it out"


def _motor(values: Values, inputs: list[str]) -> Iterator[tuple[str, str, str]]:
    """Yield what a motor has that goes with another word: gains with an input, resistance to heat with a capacity."""
    gains, thermal = (_numbers(values, word) for word in ("controller", "thermal"))
    if any(gains[:4]) and not {"pos", "vel", "ff"} & {*inputs}:
        yield (
            "controller",
            "has gains of a controller and no input for it",
            'write input: "pos", or some of: pos vel ff',
        )
    elif any(gains[1:2]) and "pos" not in inputs:
        yield "controller", "has an integral gain and no input pos", f'write input: "{" ".join(["pos", *inputs])}"'
    if any(thermal) and not (len(thermal) > 1 and min(thermal[:2]) > 0):
        yield "thermal", "has no thermal resistance and capacitance above zero", "write both: [RESISTANCE, CAPACITANCE]"


def _kinds(values: Values) -> Iterator[tuple[str, str, str]]:
    """Yield what a general actuator has of one type and lacks to be of it."""
    dynamics, gain, bias = (str(values.get(word, "")) for word in ("dyntype", "gaintype", "biastype"))
    integrates = _numbers(values, "gainprm")[:1] != (0,)
    if (dynamics == "pid" and gain != "pid") or (
        gain == "pid" and (bias != "affine" or (integrates and dynamics != "pid"))
    ):
        word = "gaintype" if gain == "pid" else "dyntype"
        yield word, "is a pid in parts", "write dyntype: pid, gaintype: pid and biastype: affine, or take the type pid"
    turning = _numbers(values, "gainprm")[:1] or (1.0,), _numbers(values, "biasprm")[1:2] or (0.0,)
    if gain == bias == "so3" and turning[0][0] != -turning[1][0]:
        yield "gaintype", "is so3 and has another gain than bias", "write gainprm: [KP] and biasprm: [0, -KP]"
    for word, numbers in (("gaintype", "gainprm"), ("biastype", "biasprm")):
        said = _numbers(values, numbers)
        if values.get(word) == "muscle" and not _is_muscle(said):
            yield word, f"is a muscle without its numbers in {numbers}", "write them, or take the type muscle"
    if "input" in values and gain in ("muscle", "user"):
        yield "input", f"has an input and a gain of type {gain}", "leave it out"
    elif "input" in values and gain in ("", "fixed", "affine") and values["input"] not in _ONE_INPUT:
        yield "input", f"has an input {values['input']}", "write one of: pos, vel, pressure"


def _is_muscle(said: tuple[float, ...]) -> bool:
    """Say whether numbers are those of a muscle: its range, and scale, vmax, fpmax and fvmax above zero."""
    return len(said) > 8 and said[0] < said[1] and min(said[3], *said[6:9]) > 0


def _numbers(values: Values, word: str) -> tuple[float, ...]:
    """Return the numbers of an attribute; none if it is not said."""
    said = values.get(word)
    if isinstance(said, tuple):
        return tuple(map(float, said))
    return (said,) if isinstance(said, float) else ()
