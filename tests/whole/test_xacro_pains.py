"""Complaints about xacro (survey, 2026-11) that do not hold here: speed. Without ROS: commands/command-line.md.

Places of errors, numbers and versions: commands/xacro-pains.md; eval: test_xacro_escapes.py.
"""

import sys
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.request import prove
from support.paths import ROOT, data_text

# Time grows with the robot, no faster (ros/xacro#57, #292); the benchmarks have the seconds.


@pytest.mark.slow
def test_work_grows_with_the_number_of_uses(tmp_path: Path) -> None:
    """A board with pegs, and a chain whose links all move and are above each other."""
    pegs = f"robot: r\noutputs: {{urdf: {{file: r.urdf}}}}\n{data_text('robots/xacro_pains_peg.yaml')}"
    chain = (ROOT / "benchmarks" / "segment.yaml").read_text("utf-8").replace("range(n)", "range(COUNT)")
    for text, most in ((pegs, 4_000), (chain, 8_000)):
        _calls(tmp_path, text, 100)  # the first run fills caches
        calls = {count: _calls(tmp_path, text, count) for count in (100, 200, 400)}
        first, second = calls[200] - calls[100], calls[400] - calls[200]
        assert second < 2.2 * first, f"twice the uses take {second / first:.2f} times the calls"
        assert first / 100 < most, f"{first / 100:.0f} calls for a use"


def _calls(folder: Path, text: str, count: int) -> int:
    """Return how many functions are called to compile a robot with so many parts, and to read it back."""
    (folder / "robot.yaml").write_text(text.replace("COUNT", str(count)), "utf-8")
    calls = 0

    def watch(_frame: Any, event: str, _argument: Any) -> None:
        nonlocal calls
        calls += event == "call"

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        made = prove(compile_robot(folder / "robot.yaml"))
    finally:
        sys.setprofile(before)
    assert made.artifacts, made.diagnostics
    return calls


# No ROS (ros/xacro#197, #328, #329, #340).
