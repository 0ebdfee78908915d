"""Proof: the MJCF that an imported one becomes is held against it in MuJoCo, and what differs is told or known.

MuJoCo compiles both in a child process (``engine``, ``compared``, ``moves``). What the import has listed as left out,
ignored or changed differs as it said; all else that differs is a fault.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.compare.proof import Found, Proof
from rosorin_compile.formats.imported import Imported
from rosorin_compile.source.diagnostics import counted, listed

from .process import prove as ask

_GONE = r": is not in ours$"
_RENAMED = r": is called "


class Listed(NamedTuple):
    """What a message of an import has in it, the features that may differ then, and how, as a regular expression."""

    words: str
    features: tuple[str, ...]
    how: str = ""


_OF_JOINTS = (
    *("types of joints", "forces of joints", "springs", "tuning of joints", "ranges of joints", "damping", "armature"),
    *("friction loss", "gravity compensation", "groups", "user data"),
)
LISTED: tuple[Listed, ...] = (
    Listed(
        "of the world: the scene",
        ("shapes", "shine", "textures", "sites", "cameras", "lights", "touching", "user data"),
        rf"{_GONE}|^body world and .* may touch in the source alone$",
    ),
    Listed("that no geom has", ("shapes",), _GONE),
    Listed("that no material has", ("textures",), _GONE),
    Listed("becomes the link", ("names",), _RENAMED),
    Listed('is called "', ("names",), _RENAMED),
    Listed("no range limit", ("ranges of joints",)),
    Listed(" of the free joint ", _OF_JOINTS),
    Listed(" of the joint ", _OF_JOINTS),
    Listed(" of a geom ", ("shapes", "contact", "drag", "looks", "groups", "user data")),
    Listed(" of the body ", ("gravity compensation", "motion capture", "sleep", "user data")),
    Listed(" of the material ", ("shine", "textures")),
    Listed(" of the actuator ", ("actuators", "groups", "user data")),
    Listed("its control is not where it was", ("order", "keys")),
    Listed(" of a key ", ("keys",)),
    Listed("move a little otherwise", ("motion",)),
    Listed("the setting ", ("options",)),
    Listed("the tendon ", ("tendons",), _GONE),
    Listed("the equality ", ("equalities",), _GONE),
    Listed("the sensor ", ("sensors",), _GONE),
)
"""What an import says of what it leaves out, ignores or changes; all that differs otherwise is a fault."""

STILL = (
    "names",
    "groups",
    "looks",
    "colours",
    "shine",
    "textures",
    "looks of sites",
    "cameras",
    "lights",
    "numbers and texts",
    "user data",
    "settings of the viewer",
    "sensors",
    "keys",
    "sizes",
    "skins",
)
"""The features that no motion sees."""

_LISTS = ("import-cannot-carry", "import-ignored", "import-changed", "import-stand-in")


def prove(imported: Imported, text: str, files: Mapping[str, str]) -> Proof:
    """Return how the MJCF of an imported one differs from it; ``files`` are its meshes, by the names in the text."""
    return Proof.of(imported, (text, files), _by_mujoco)


def _by_mujoco(imported: Imported, made: tuple[str, Mapping[str, str]]) -> Found | str:
    """Return what MuJoCo tells apart; ``made`` is the MJCF with its files."""
    text, files = made
    answer = ask(imported.files[0], {"text": text, "files": dict(files), "names": imported.names, "still": STILL})
    if isinstance(answer, str):
        return answer
    if "refused" in answer:
        return Found([("loading", f"MuJoCo does not load the MJCF that it becomes: {answer['refused']}")])
    motion = answer.get("motion")
    moved = [("motion", _moved(motion))] if motion and motion["verdict"] == "differs" else []
    said = [d.message for d in imported.diagnostics if d.rule in _LISTS]
    return Found(
        [*moved, *answer["differences"]],
        lambda feature, difference: is_listed(feature, difference, said),
        lambda features: _in_words(features, motion),
        answer.get("counts", {}),
    )


def is_listed(feature: str, difference: str, said: Sequence[str]) -> bool:
    """Say whether a message of an import says that something of a feature differs in this way."""
    ways = (one for one in LISTED if feature in one.features and any(one.words in message for message in said))
    return any(re.search(one.how, difference) for one in ways)


def _moved(motion: Mapping[str, Any]) -> str:
    where = f" ({motion['body']})" if motion["body"] else ""
    apart = f"{motion['largest']:.2g}" if math.isfinite(motion["largest"]) else "without end"
    return f"after {motion['steps']} steps with moving controls the two are apart by {apart}{where}"


def _in_words(known: Sequence[str], motion: Mapping[str, Any] | None) -> str:
    """Return what was shown, but for the features of which something was told, as a sentence."""
    but = f"but for what is listed above ({listed(known)})" if known else "in every field that it decides"
    sentence = f"MuJoCo's model of the MJCF is that of the source, {but}"
    return sentence + (f"; {_how_it_moved(motion)}" if motion else "")


def _how_it_moved(motion: Mapping[str, Any]) -> str:
    steps, touching = counted(motion["steps"], "step"), counted(motion["contacts"], "contact")
    steps += " without the scene" if motion.get("scene") else ""
    if motion["verdict"] == "unstable":
        return "the source does not come through a simulation with moving controls"
    if motion["verdict"] == "differs":
        return f"{steps} with moving controls: apart by {motion['largest']:.2g}"
    if motion["verdict"] == "same":
        return f"{steps} with moving controls and up to {touching}: largest difference {motion['largest']:.2g}"
    return (
        f"{steps} with moving controls are chaotic: apart by {motion['largest']:.2g}, where the source, moved by no"
        f" more than rounding, is apart from itself by {motion['itself']:.2g}; without contact by"
        f" {motion['without_contact']:.2g}"
    )
