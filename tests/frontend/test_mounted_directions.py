"""What sits on the mount of a part may have a direction beside its pose: the schema says so by ``x-attached``."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.language.annotations import Node
from rosorin_compile.language.expand import placing
from rosorin_compile.language.symbols import SymbolTable
from rosorin_compile.source.load import load_mapping

POSE, WHOLE = ("xyz", "rpy"), ("xyz", "rpy", "ray")
MOVED, TURNED = [1, 2, 3], [0, 0, pi / 2]


def lamp(folder: Path, said: str, keys: Sequence[str], xyz: Any = MOVED, rpy: Any = TURNED) -> dict[str, Any]:
    """Return a lamp on the mount of a part that is used at ``base``, with a pose."""
    (folder / "part.yaml").write_text(f"lamps: [{{at: mount{said}}}]\n", "utf-8")
    link = Node(names="link", attached=keys, of=frozenset({"link"}))
    lamps = Node(items=Node(properties={"at": link}, of=link.of), of=link.of, in_parts=True, merge="items")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(placing, "sections", lambda: {"lamps": lamps})
        part = load_mapping(folder / "part.yaml", "part.yaml")
        names = SymbolTable(part)
        (one,) = placing.placed(part, placing.Use("l_", "base", xyz, rpy), names)["lamps"]
    return dict(one)


@pytest.mark.parametrize(
    ("said", "keys", "expected"),
    [
        ("", POSE, {"xyz": MOVED, "rpy": TURNED}),
        ("", ("xyz",), {"xyz": MOVED}),
        ("", ("ray",), {}),
        ("", WHOLE, {"xyz": MOVED, "rpy": TURNED}),
        (", xyz: [1, 0, 0]", POSE, {"xyz": [1, 3, 3], "rpy": TURNED}),
        (", rpy: [0, 0, 1.5]", POSE, {"xyz": MOVED, "rpy": [0, 0, pi / 2 + 1.5]}),
        (", ray: [1, 0, 0]", ("ray",), {"ray": [0, 1, 0]}),
        (", ray: [1, 0, 0]", WHOLE, {"xyz": MOVED, "rpy": TURNED, "ray": [0, 1, 0]}),
        (", xyz: [0, 1, 0], ray: [0, 0, 1]", WHOLE, {"xyz": [0, 2, 3], "rpy": TURNED, "ray": [0, 0, 1]}),
        (", xyz: [0, 1, 0], ray: [0, 1, 0]", ("ray",), {"xyz": [0, 1, 0], "ray": [-1, 0, 0]}),
    ],
)
def test_a_direction_turns_with_the_use_and_a_place_moves(
    said: str, keys: Sequence[str], expected: dict[str, Any], tmp_path: Path
) -> None:
    made = lamp(tmp_path, said, keys)
    assert made.pop("at") == "base"
    assert made.keys() == expected.keys()
    for key, values in expected.items():
        assert made[key] == pytest.approx(values, abs=1e-12)


@pytest.mark.parametrize(
    ("said", "xyz"),
    [
        (", ray: up, xyz: [1, 0, 0]", MOVED),
        (", ray: [1, 0], xyz: [1, 0, 0]", MOVED),
        (", ray: [1, 0, 0], xyz: [1, 0]", MOVED),
        (", ray: [1, 0, 0], rpy: flat", MOVED),
        (", ray: [1, 0, 0]", "there"),
    ],
)
def test_what_is_no_direction_is_left_for_the_schema_to_tell(said: str, xyz: Any, tmp_path: Path) -> None:
    before = lamp(tmp_path, said, ())
    assert lamp(tmp_path, said, WHOLE, xyz) == before
