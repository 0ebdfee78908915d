"""Progress: on the last line of a terminal, with never a letter of it left."""

import io
import itertools
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import of_a_person

CHAIN = """robot: chain
parts:
  segment:
    links: {link: {inertial: {mass: 1, inertia: {ixx: 1, iyy: 1, izz: 1}}}}
    joints: {joint: {type: fixed, parent: mount, child: link}}
links: {base_link: {}}
use:
  "s${i}": {for: {i: "${range(2000)}"}, part: segment, parent: base_link}
outputs: {urdf: {file: chain.urdf}, static_tf_json: {file: static_tf.json}}
"""


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True

    def fileno(self) -> int:
        raise OSError

    def left(self) -> str:
        """Return what stands on the terminal in the end: each line as it was last written."""
        lines = []
        for line in self.getvalue().split("\n"):
            seen = ""
            for piece in line.split("\r"):
                text, wiped, more = piece.partition("\x1b[K")
                seen = text + (more if wiped else seen[len(text) :])
            lines.append(seen)
        return "\n".join(lines)


def sit_down(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Return the terminal that is standard error from now on, where a clock goes a second at each look."""
    made = Terminal()
    monkeypatch.setattr(sys, "stderr", made)
    monkeypatch.setenv("TERM", "xterm")
    slow_down(monkeypatch)
    return made


def slow_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.delenv("ROSORIN_COMPILE_PROGRESS")
    ticks = itertools.count()
    monkeypatch.setattr("rosorin_compile.source.progress.time.monotonic", lambda: float(next(ticks)))


@pytest.mark.slow
def test_every_stage_of_a_large_robot_is_shown(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    person = sit_down(monkeypatch)
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0}, raising=False)  # another process may do all the making
    (home / "chain.yaml").write_text(CHAIN)
    assert main(["all", "chain.yaml"]) == 0
    shown = person.getvalue()
    kinds = re.findall(r"\r([a-z ]+?)(?:,| [\d\[]|\x1b| [a-z_]+\.)", shown)
    order = ["expanding parts", "validating", "building the robot", "checking", "making", "proving"]
    assert [one for one in dict.fromkeys(kinds) if one in order] == order
    assert "\rexpanding parts 1,999\x1b[K" in shown
    assert "\rproving static_tf.json, 0 of 2 [" in shown
    assert person.left() == ""
    assert capsys.readouterr().out.startswith("chain: 2 artifacts in ")
    assert main(["check", "chain.yaml", "--every-argument"]) == 0
    assert main(["check", "chain.yaml"]) == 0
    assert "\rcomparing chain.urdf, " in person.getvalue()
    assert person.left() == ""


SILENT = ["all -q", "all --format json", "all --format sarif", "check -q"]


@pytest.mark.parametrize("words", SILENT)
def test_not_when_quiet_and_not_for_programs(home: Path, monkeypatch: pytest.MonkeyPatch, words: str) -> None:
    (home / "chain.yaml").write_text(CHAIN.replace("2000", "20"))
    assert main(["all", "chain.yaml", "-q"]) == 0
    person = sit_down(monkeypatch)
    assert main([*words.split(), "chain.yaml"]) == 0
    assert not re.search("expanding|validating|proving", person.getvalue())
    monkeypatch.setenv("CI", "true")
    assert main([*words.split(), "chain.yaml"]) == 0
    assert not re.search("expanding|validating|proving", person.getvalue())


@pytest.mark.parametrize("words", ["print chain.yaml urdf", "print chain.yaml urdf -v", "print chain.yaml --list"])
def test_no_line_where_a_launch_file_takes_it_for_a_failure(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: str
) -> None:
    (home / "chain.yaml").write_text(CHAIN.replace("2000", "20"))
    slow_down(monkeypatch)
    assert main(words.split()) == 0
    assert "validating" not in capsys.readouterr().err


def test_nothing_is_shown_where_the_variable_says_so(
    home: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (home / "chain.yaml").write_text(CHAIN.replace("2000", "20"))
    slow_down(monkeypatch)
    monkeypatch.setenv("ROSORIN_COMPILE_PROGRESS", "off")
    assert main(["all", "chain.yaml"]) == 0
    assert capsys.readouterr().err == ""
    person = sit_down(monkeypatch)
    monkeypatch.setenv("ROSORIN_COMPILE_PROGRESS", "off")
    assert main(["check", "chain.yaml"]) == 0
    assert person.getvalue() == ""


@pytest.mark.slow
def test_ctrl_c_leaves_nothing_behind(home: Path) -> None:
    (home / "chain.yaml").write_text(CHAIN)
    code = "import itertools, rosorin_compile.source.progress as p\n"
    code += "p.time.monotonic = lambda c=itertools.count(): float(next(c))\n"
    code += "from rosorin_compile.cli.main import main\nraise SystemExit(main(['all', 'chain.yaml']))\n"
    terminal, other_end = os.openpty()
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=home, env=of_a_person(), stdout=other_end, stderr=other_end
    )
    os.close(other_end)
    said = b""
    while b"expanding parts" not in said:
        said += os.read(terminal, 10_000)
    process.send_signal(signal.SIGINT)
    try:
        while piece := os.read(terminal, 10_000):
            said += piece
    except OSError:  # what Linux says when the other end of a terminal is closed
        pass
    os.close(terminal)
    assert process.wait() == 130
    assert said.endswith(b"\r\x1b[K")
    assert b"Traceback" not in said
