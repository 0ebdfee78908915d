"""The same description gives the same bytes, whatever the machine, the folder and the order of keys."""

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosorin_compile.source.load import load_mapping
from support.paths import ROOT, ROSORIN
from support.robots import MOVING, compiled, copy_of_rosorin, of_this_project, texts

# The entries of these mappings stand in the artifacts in the order of the description, and so does what is repeated.
ORDERED = ("joints", "sensors", "use")
REPEATED = "for"


@pytest.mark.landing("fuzz", "4711-tr_TR.UTF-8-UTC")
@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "locale", "zone"), [("0", "C", "UTC"), ("1", "de_DE.UTF-8", "Asia/Tokyo"), ("4711", "tr_TR.UTF-8", "UTC")]
)
def test_same_bytes_in_another_process_locale_and_folder(tmp_path: Path, seed: str, locale: str, zone: str) -> None:
    folder = tmp_path / f"a folder {seed}"
    copy_of_rosorin(folder, whole=True)
    environment = {**os.environ, "PYTHONHASHSEED": seed, "LC_ALL": locale, "LANG": locale, "TZ": zone}
    environment["ROSORIN_COMPILE_CACHE"] = "off"
    command = [sys.executable, "-m", "rosorin_compile", "all"]
    subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
    written = {path.name: path.read_bytes() for path in (folder / "outputs" / "rosorin").iterdir()}
    assert written == {name: text.encode() for name, text in texts(compiled()).items()}


def test_no_artifact_names_a_path_of_this_machine() -> None:
    for name, text in texts(compiled()).items():
        assert str(ROOT) not in text, name
        assert str(Path.home()) + "/" not in text, name


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32))
def test_order_of_keys_that_carry_none_changes_nothing(tmp_path: Path, seed: int) -> None:
    shuffle = random.Random(seed)  # noqa: S311 - a test
    for path in sorted(ROSORIN.parent.glob("*.yaml")):
        text = path.read_text("utf-8")
        if path.name not in MOVING:  # whose order is that of controllers, and of what they move
            tree = load_mapping(path, path.name)
            shuffled = _shuffled(tree, shuffle)
            for section in ORDERED:
                if section in tree:
                    shuffled[section] = {name: _shuffled(entry, shuffle) for name, entry in tree[section].items()}
            text = json.dumps(shuffled)  # JSON is YAML: every number keeps its digits, every text its letters
        (tmp_path / path.name).write_text(text, "utf-8")
    assert texts(compiled(tmp_path / "robot.yaml")) == texts(of_this_project(ROSORIN))


def _shuffled(value: object, shuffle: random.Random) -> object:
    if isinstance(value, dict):
        keys = list(value)
        shuffle.shuffle(keys)
        return {key: value[key] if key == REPEATED else _shuffled(value[key], shuffle) for key in keys}
    if isinstance(value, list):
        return [_shuffled(item, shuffle) for item in value]
    return value
