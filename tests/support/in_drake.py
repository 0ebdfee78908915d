"""What Drake makes of an SDF: the format's engine, run with the Python that has Drake (DRAKE, as .ci/run sets it)."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

ENGINE = Path(__file__).with_name("drake_engine.py")

PYTHON = os.environ.get("DRAKE", "")


def need() -> None:
    """Skip the test where Drake is not installed."""
    import pytest

    if not PYTHON:
        pytest.skip("DRAKE names no Python that has Drake: pip install drake==1.51.1 in an environment of its own")


class Refused(Exception):
    """What Drake says that it does not load."""


def ask(path: Path, root: str, states: list[dict[str, Any]] | None = None, *, quiet: bool = True) -> dict[str, Any]:
    """Return what Drake reads out of an SDF.

    ``frames``: 4x4 poses in the frame ``root``, by name, for each of the states (positions by joint); ``masses`` and
    ``inertias`` (3x3 about the centre of mass along the link, and the centre) by link; ``joints``: type, axis and
    limits by name. A link or frame of a model within is called MODEL_NAME. With ``quiet`` Drake may warn of nothing
    but sensors and what it cannot do in this plant.
    Raises Refused.
    """
    words = json.dumps({"files": [str(path)], "root": root, "states": states or [{}]})
    ran = subprocess.run(
        [PYTHON, "-P", str(ENGINE)], input=words, capture_output=True, text=True, timeout=120, check=False
    )
    assert ran.returncode == 0, ran.stderr
    found: dict[str, Any] = json.loads(ran.stdout)[0]
    if "refused" in found:
        raise Refused(found["refused"].strip())
    if quiet:
        known = ("in link: sensor", "in joint: sensor", "imic element", "Coulomb friction", "gravity", "model: plugin")
        told = [line for line in ran.stderr.splitlines() if "warning" in line.lower()]
        assert [line for line in told if not any(word in line for word in known)] == []
    return found
