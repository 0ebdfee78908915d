"""Prove that the MJCF of an imported one is the same robot to MuJoCo, except for what the import reported.

MuJoCo compiles and compares both in a child process (``engine``, ``compare_models``). What the
import listed as left out, ignored or changed may differ in that way; any other difference is a fault.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from rosorin_compile.formats.imported_robot import Imported, Proof
from rosorin_compile.source.diagnostics import phrase

from .process import prove as prove_in_child

_GONE = r".*: is not in ours$"
# Words of messages of an import, and what may then differ: a pattern for "kind field: text".
LISTED = {
    "of the world: the scene": rf"(geom|mesh|hfield|site|camera) {_GONE}|geom user"
    r"|contact : body world and .* may touch in the source alone$",
    "becomes the link": r"\w+ name:",
    'is called "': r"\w+ name:",
    "no range limit": r"joint (range|limited):",
    " of the free joint ": r"joint (?!name)",
    " of the joint ": r"joint (?!name)",
    " of a geom ": r"geom (?!name|contype|conaffinity)",
    " of the body ": r"body (gravcomp|mocapid|sleep|user):",
    " of the actuator ": r"actuator (?!name)",
    "its control is not where it was": r"order |key ",
    "sensor data is in another order": r"order sensor",
    " of a key ": r"key ",
    "move a little otherwise": r"motion ",
    "the setting ": r"option ",
    "the tendon ": rf"tendon {_GONE}",
    "the equality ": rf"equality {_GONE}",
    "the sensor ": rf"sensor {_GONE}",
}
_LISTS = ("import-cannot-carry", "import-ignored", "import-changed", "import-stand-in")


def prove(imported: Imported, text: str, files: Mapping[str, str]) -> Proof:
    """Return how the MJCF of an imported one differs from it; ``files`` are its meshes, by the names in the text."""
    answer = prove_in_child(imported.files[0], {"text": text, "files": dict(files), "names": imported.names})
    if isinstance(answer, str):
        return Proof(unknown=answer)
    if "refused" in answer:
        return Proof({"loading": [f"MuJoCo does not load the MJCF that it becomes: {answer['refused']}"]})
    wrong, known = dict[str, list[str]](), dict[str, list[str]]()
    messages = [one.message for one in imported.diagnostics if one.rule in _LISTS]
    for kind, field, text in answer["differences"]:
        by_feature = known if is_listed(f"{kind} {field}: {text}", messages) else wrong
        by_feature.setdefault(f"{kind} {field}".strip(), []).append(text)
    if wrong:
        return Proof(wrong, known)
    but = f"except for what is listed above ({phrase(list(known))})" if known else "in every field but its appearance"
    motion = f"; frames and accelerations {answer['motion']}" if "motion" in answer else ""
    return Proof(wrong, known, f"MuJoCo's model of the MJCF is that of the source, {but}{motion}")


def is_listed(difference: str, messages: Sequence[str]) -> bool:
    """Return True if a message of an import lists a difference, a text "KIND FIELD: TEXT"."""
    patterns = [pattern for words, pattern in LISTED.items() if any(words in message for message in messages)]
    return any(re.match(pattern, difference) for pattern in patterns)
