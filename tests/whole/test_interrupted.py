"""Ctrl-C at any moment, also while the program is still being imported: no traceback, and the shell's exit code."""

import re
import signal
import subprocess
import sys
import time

import pytest

from support.paths import ROOT

MOMENTS = [0.01 * step for step in range(1, 40, 3)]
INTERRUPTED = (-signal.SIGINT, 130)


# Until these two have run, or what leads to a checkout, Python answers itself.
FIRST = re.compile(r"/rosorin_compile/__(init|main)__\.py\", line \d+, in <module>$")


def in_the_program(said: str) -> list[str]:
    """Return the lines of a traceback that name a file of the package, but for the first two that Python runs."""
    return [line for line in said.splitlines() if "/rosorin_compile/" in line and not FIRST.search(line)]


@pytest.mark.slow
def test_an_interrupt_is_no_traceback() -> None:
    ended = []
    for moment in MOMENTS:
        command = [sys.executable, "-m", "rosorin_compile", "print", "rosorin", "urdf"]
        with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
            time.sleep(moment)
            run.send_signal(signal.SIGINT)
            out, said = run.communicate(timeout=60)
        assert in_the_program(said) == [], said
        ended.append(run.returncode)
        assert run.returncode in (*INTERRUPTED, 0, 1)
        assert run.returncode != 0 or out.endswith("</robot>\n")
    assert any(code in INTERRUPTED for code in ended)


AT = """
import os, signal, sys
from rosorin_compile.__main__ import program
from rosorin_compile.cli import main as cli

def interrupted(*given):
    os.kill(os.getpid(), signal.SIGINT)

cli.guard = interrupted
sys.argv = ["rosorin-compile", "print", "--nonsense"]
raise SystemExit(program())
"""


def test_an_interrupt_beside_the_command_is_no_traceback() -> None:
    program = [sys.executable, "-c", AT]
    ran = subprocess.run(program, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)
    assert (ran.returncode, "Traceback" in ran.stderr) == (130, False)
