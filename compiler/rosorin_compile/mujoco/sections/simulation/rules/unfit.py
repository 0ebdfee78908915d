"""Attributes of actuators that MuJoCo takes of their type only with others, or with other numbers.

Found by giving MuJoCo 4.0 every word of every type: what it refuses is reported here at its line.
"""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model.simulation import Actuator, Attribute

# The inputs of each type, in MuJoCo's order.
_INPUTS = {
    "orientation": ("expmap", "quat"),
    "pid": ("pos", "vel", "ff"),
    "dcmotor": ("pos", "vel", "ff", "voltage", "none"),
    "general": ("pos", "vel", "ff", "voltage", "pressure", "none", "expmap", "quat"),
}
_ONE_INPUT = ("pos", "vel", "pressure", "expmap")  # of a gain that is fixed or affine
# Numbers that may not be below zero, by type; of a muscle those that may not be zero.
_SIZES = {"pid": ("slewmax",), "adhesion": ("gain",), "dcmotor": ("motorconst", "resistance", "inductance")}
_MUSCLE = ("scale", "vmax", "fpmax", "fvmax")
_ONE_STATE = (None, "none", "user", "dcmotor", "pid")  # other dynamics have one activation

Wrong = tuple[object, str, str, str]  # whether it is so, the attribute, the message, the way out


def unfit(actuator: Actuator) -> Iterator[tuple[str, str, str]]:
    """Yield attributes that MuJoCo takes of its type only with others, or in another form: word, message, way out."""
    for is_wrong, word, message, help in (*_of_all(actuator), *_of_general(actuator), *_of_kinds(actuator)):
        if is_wrong:
            yield word, message, help


def _of_all(actuator: Actuator) -> Iterator[Wrong]:
    values, targets, kind = actuator.mjcf, set(actuator.targets), actuator.type
    is_crankless = "cranklength" in values and "cranksite" not in targets
    help = "write slider_site and crank_site, or leave it out"
    yield is_crankless, "cranklength", "has a cranklength and no crank", help
    is_elsewhere = targets and not targets & {"joint", "tendon", "jointinparent"}
    for word in ("damping", "armature"):
        message = f"has {word}, which only joints and tendons take"
        yield is_elsewhere and word in values, word, message, "leave it out"
    times, count = _numbers(values.get("timeconst")), 2 if kind == "muscle" else 1
    help = "write two numbers: activation, deactivation" if kind == "muscle" else "write one number"
    message = f"has {len(times)} time constant{'s' if len(times) > 1 else ''}"
    yield times and len(times) != count, "timeconst", message, help
    yield len(times) == 1 and times[0] < 0, "timeconst", "has a time constant below zero", "write a time"
    words, legal = str(values.get("input", "")).split(), _INPUTS.get(kind, ())
    help = f"write some of: {' '.join(legal)}, in this order"
    yield words != [one for one in legal if one in words], "input", f'has an input "{" ".join(words)}"', help
    smooth = _numbers(values.get("tausmooth"))
    yield smooth and smooth[0] < 0, "tausmooth", "is smoothed over a time below zero", "write a time"
    low, high = ((*_numbers(values.get(word)), usual)[0] for word, usual in (("lmin", 0.5), ("lmax", 1.6)))
    word = "lmin" if "lmin" in values else "lmax"
    yield not low < 1 < high, word, "has lengths that are not around 1", "write lmin < 1 < lmax"


def _of_general(actuator: Actuator) -> Iterator[Wrong]:
    """Yield what a general actuator has of one type and lacks to be of it."""
    values, numbers = actuator.mjcf, _numbers
    state = values.get("dyntype")
    message = f"has one activation, that of {state}"
    is_single = "actdim" in values and state not in _ONE_STATE and values["actdim"] != 1
    if actuator.type != "general":
        yield is_single, "actdim", message, "leave it out"
        return
    for word in ("actdim", "actrange", "actlimited"):
        yield (
            state in (None, "none") and values.get(word),
            word,
            f"has {word} and no activation",
            "say its dyntype, or leave it out",
        )
    yield is_single, "actdim", message, "leave it out"
    dynamics, gain, bias = (str(values.get(word, "")) for word in ("dyntype", "gaintype", "biastype"))
    gains, biases = numbers(values.get("gainprm")), numbers(values.get("biasprm"))
    word, help = "gaintype" if gain == "so3" else "biastype", "write both, or take the type orientation"
    yield (gain == "so3") != (bias == "so3"), word, "is so3 in one of gaintype and biastype", help
    word = "dyntype" if dynamics == "dcmotor" else "gaintype"
    is_motor = "dcmotor" in (dynamics, gain) and values.get("actearly") is not True
    yield is_motor, word, "is a dcmotor in parts", "take the type dcmotor"
    half = gain == "pid" and (bias != "affine" or (gains[:1] != (0,) and dynamics != "pid"))
    help = "write dyntype: pid, gaintype: pid and biastype: affine, or take the type pid"
    word = "gaintype" if gain == "pid" else "dyntype"
    yield half or (dynamics == "pid" and gain != "pid"), word, "is a pid in parts", help
    is_uneven = gain == bias == "so3" and (*gains, 1.0)[0] != -(*biases[1:2], 0.0)[0]
    help = "write gainprm: [KP] and biasprm: [0, -KP]"
    yield is_uneven, "gaintype", "is so3 and has another gain than bias", help
    for word, said in (("gaintype", gains), ("biastype", biases)):
        # The range of a muscle, and scale, vmax, fpmax and fvmax above zero.
        is_muscle = len(said) > 8 and said[0] < said[1] and min(said[3], *said[6:9]) > 0
        message = f"is a muscle without its numbers in {word[:4]}prm"
        yield values.get(word) == "muscle" and not is_muscle, word, message, "write them, or take the type muscle"
    has_input = "input" in values
    message = f"has an input and a gain of type {gain}"
    yield has_input and gain in ("muscle", "user"), "input", message, "leave it out"
    is_other = has_input and gain in ("", "fixed", "affine") and values["input"] not in _ONE_INPUT
    yield is_other, "input", f"has an input {values.get('input')}", "write one of: pos, vel, pressure"


def _of_kinds(actuator: Actuator) -> Iterator[Wrong]:
    """Yield what a pid, a muscle and a motor have that goes with another word, and numbers below zero, or zero."""
    values, kind = actuator.mjcf, actuator.type
    inputs, integral = str(values.get("input", "")).split(), any(_numbers(values.get("ki")))
    sizes = _SIZES.get(kind, ())
    if kind == "pid" and integral:
        sizes = (*sizes, "imax") if any(_numbers(values.get("slewmax"))) else (*sizes, "ki", "imax")
    for word in sizes:
        is_below = min(_numbers(values.get(word)), default=0) < 0
        yield is_below, word, f"has {word} below zero", "write it without the sign"
    for word in _MUSCLE if kind == "muscle" else ():
        help = "write a number above zero, or leave it out"
        yield 0 in _numbers(values.get(word)), word, f"has {word} zero", help
    for word in ("ki", "slewmax") if kind == "pid" and inputs and "pos" not in inputs else ():
        help = f'write input: "{" ".join(["pos", *inputs])}", or leave it out'
        yield any(_numbers(values.get(word))), word, f"has {word} and no input pos", help
    if kind == "dcmotor":
        gains, thermal = (_numbers(values.get(word)) for word in ("controller", "thermal"))
        is_blind = any(gains[:4]) and not {"pos", "vel", "ff"} & {*inputs}
        help = 'write input: "pos", or some of: pos vel ff'
        yield is_blind, "controller", "has gains of a controller and no input for it", help
        is_integral, help = any(gains[1:2]) and "pos" not in inputs, f'write input: "{" ".join(["pos", *inputs])}"'
        yield is_integral and not is_blind, "controller", "has an integral gain and no input pos", help
        is_warm = any(thermal) and not (len(thermal) > 1 and min(thermal[:2]) > 0)
        help = "write both: [RESISTANCE, CAPACITANCE]"
        yield is_warm, "thermal", "has no thermal resistance and capacitance above zero", help


def _numbers(value: Attribute) -> tuple[float, ...]:
    """Return the numbers of an attribute; none if it is not set."""
    if isinstance(value, tuple):
        return tuple(map(float, value))
    return (value,) if isinstance(value, float) else ()
