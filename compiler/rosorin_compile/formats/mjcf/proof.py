"""Proof: the MJCF that an imported one becomes is held against it in MuJoCo, and what differs is told or known.

MuJoCo compiles both in a child process (``engine``, ``same``, ``moves``). What the import has listed as left out,
ignored or changed differs as it said; all else that differs is a fault.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...diagnostics.wording import counted, listed
from ..imported import Imported, Proof
from .process import prove as ask
from .same_fields import LISTED_AS, STILL

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
    return Proof(wrong, known, _in_words(wrong, known, motion))


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
        sentence = f"MuJoCo's model of the MJCF is that of the source, but for what is listed above ({listed(list(known))})"
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
        f"{steps} with moving controls are chaotic: apart by {motion['largest']:.2g}, where the source moved by one unit in"
        f" the last place is by {motion['itself']:.2g} from itself; without contact {motion['without_contact']:.2g}"
    )
