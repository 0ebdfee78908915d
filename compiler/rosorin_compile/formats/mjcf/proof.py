"""Proof: the MJCF that an imported one becomes is held against it in MuJoCo, and what differs is told or known.

MuJoCo compiles both in a child process (``engine``, ``same``, ``moves``). What the import has listed as left out,
ignored or changed differs as it said; all else that differs is a fault.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ...diagnostics.wording import counted, listed
from ..imported import Imported, Proof
from .process import prove as ask

LISTED_AS: Mapping[str, tuple[str, ...]] = {
    "options": ("of options",),
    "sizes": ("settings of the simulation",),
    "settings of the viewer": ("settings of the viewer",),
    "names": ("the name of an equality", "the names of", "becomes the link", "what MuJoCo has for mass"),
    "places of bodies": ("the body stands at",),
    "motion capture": ("motion capture", "motion of bodies"),
    "sleep": ("sleep policy",),
    "gravity compensation": ("compensation of gravity",),
    "types of joints": ("the ball joint",),
    "forces of joints": ("which has one size both ways", "no effort limit", "actuator"),
    "springs": ("springs of joints", "springs", "the ball joint"),
    "tuning of joints": ("the tuning of limits and friction", "the ball joint"),
    "ranges of joints": ("no range limit", "the ball joint"),
    "damping": ("of the free joint", '"damping', "the ball joint"),
    "armature": ("of the free joint", "the ball joint"),
    "friction loss": ("of the free joint", "the ball joint"),
    "groups": ("groups of geoms", '"group"'),
    "shapes": ("that no geom has", "a geom of link", "geoms (", "of the world: the scene"),
    "masks": ("which geoms collide with which others",),
    "touching": (
        "neighbours that may touch",
        "which geoms collide with which others",
        "contact pairs",
        "a contact with the world",
        "of the world: the scene",
    ),
    "contact": ("friction and the tuning of contacts",),
    "drag": ("the drag of fluids",),
    "shine": (
        "of the world: the scene",
        "shine and texture mapping",
    ),
    "textures": ("of the world: the scene", "shine and texture mapping", "texture"),
    "looks of sites": ("how sites look", "without a name: nobody can ask"),
    "sites": ("without a name: nobody can ask", "of the world: the scene"),
    "cameras": ("the optics of cameras", "the camera ", "of the world: the scene"),
    "lights": ("of the world: the scene", "lights"),
    "contact pairs": ("contact pairs",),
    "equalities": ("the equality <", "equalities <", "of equality"),
    "tuning of equalities": ("the equality <", "equalities <"),
    "tendons": ("tendons",),
    "actuators": ("the actuator <", "actuators <"),
    "sensors": ("sensors",),
    "numbers and texts": ("numbers and texts for other programs",),
    "keys": ("time, speeds and activations", "the controls of", "where the keyframes put", "the ball joint", "key"),
    "flexible bodies": ("flexible bodies",),
    "skins": ("skins",),
    "plugins": ("plugins",),
    "user data": ('"user"', '"nuser'),
}
"""The words by which the import lists a feature as left out, as ignored or as changed; without an entry: never."""

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
    asked = {"text": text, "files": dict(files), "names": imported.names, "still": STILL}
    answer = ask(imported.files[0], asked)
    if isinstance(answer, str):
        return Proof(unknown=answer)
    by_feature: dict[str, list[str]] = {}
    for feature, what in answer["differences"]:
        by_feature.setdefault(feature, []).append(what)
    said = [d.message for d in imported.diagnostics if d.rule in _LISTS]
    known = {feature: texts for feature, texts in by_feature.items() if is_listed(feature, said)}
    wrong = {feature: texts for feature, texts in by_feature.items() if feature not in known}
    motion = answer.get("motion")
    if motion and motion["verdict"] == "differs":
        wrong["motion"] = [_moved(motion)]
    return Proof(wrong, known, _in_words(wrong, known, motion), counts=answer.get("counts", {}))


def is_listed(feature: str, said: Sequence[str]) -> bool:
    """Say whether the messages of an import have that a feature is not carried as it is."""
    return any(words in message for words in LISTED_AS.get(feature, ()) for message in said)


def _moved(motion: Mapping[str, Any]) -> str:
    where = f" ({motion['body']})" if motion["body"] else ""
    apart = f"{motion['largest']:.2g}" if math.isfinite(motion["largest"]) else "without end"
    return f"after {motion['steps']} steps with moving controls the two are apart by {apart}{where}"


def _in_words(wrong: Mapping[str, Any], known: Mapping[str, Any], motion: Mapping[str, Any] | None) -> str:
    """Return what was shown, as a sentence; empty if it does not hold."""
    if wrong:
        return ""
    if known:
        sentence = (
            f"MuJoCo's model of the MJCF is that of the source, but for what is listed above ({listed(list(known))})"
        )
    else:
        sentence = "MuJoCo's model of the MJCF is that of the source, in every field that it decides"
    return sentence + (f"; {_how_it_moved(motion)}" if motion else "")


def _how_it_moved(motion: Mapping[str, Any]) -> str:
    steps, touching = counted(motion["steps"], "step"), counted(motion["contacts"], "contact")
    if motion["verdict"] == "unstable":
        return "the source does not come through a simulation with moving controls"
    if motion["verdict"] == "same":
        return f"{steps} with moving controls and up to {touching}: largest difference {motion['largest']:.2g}"
    return (
        f"{steps} with moving controls are chaotic: apart by {motion['largest']:.2g}, where the source, moved by one"
        f" unit in the last place, is apart from itself by {motion['itself']:.2g}; without contact by"
        f" {motion['without_contact']:.2g}"
    )
