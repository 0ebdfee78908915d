"""Real shells on a terminal of their own, in which somebody types a line and presses the tabulator.

``typed`` returns what the line has become. Each shell writes its line into a file at Ctrl-X Ctrl-P.
"""

import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

_START = {
    "bash": """
        PS1='ready> '; bind 'set bell-style none' 'set enable-bracketed-paste off' 2>/dev/null
        put() { printf '%s' "$READLINE_LINE" > line.new; mv line.new line; }
        bind -x '"\\C-x\\C-p": put'
        """,
    "zsh": """
        PS1='ready> '; unsetopt zle_bracketed_paste beep; autoload -Uz compinit; compinit -u -D
        put() { print -rn -- "$BUFFER" > line.new; command mv line.new line }
        zle -N put; bindkey '^X^P' put
        """,
}
_CALLS = {"bash": ["bash", "--norc", "--noprofile", "-i"], "zsh": ["zsh", "-f", "-i"]}


class Shell:
    """A shell that waits for letters."""

    def __init__(self, terminal: int, here: Path) -> None:
        self.terminal, self.here, self.shown = terminal, here, ""

    def send(self, text: str) -> None:
        os.write(self.terminal, text.encode())

    def until(self, found: str, seconds: float = 30) -> str:
        """Read what is shown until a text stands in it."""
        end = time.monotonic() + seconds
        while found not in self.shown:
            assert time.monotonic() < end, f"{found!r} does not come: {self.shown!r}"
            self.shown += os.read(self.terminal, 10_000).decode("utf-8", "replace")
        seen, _, self.shown = self.shown.partition(found)
        return seen

    def typed(self, line: str) -> str:
        """Return what a line has become after the tabulator, and throw it away."""
        file = self.here / "line"
        file.unlink(missing_ok=True)
        self.send(f"{line}\t\x18\x10")
        end = time.monotonic() + 30
        while not file.exists():
            assert time.monotonic() < end, self.shown
            self.read_on()
        self.send("\x15")
        return file.read_text("utf-8")

    def read_on(self) -> None:
        """Take what is shown, so that the shell never waits for a reader."""
        os.set_blocking(self.terminal, False)
        try:
            self.shown += os.read(self.terminal, 10_000).decode("utf-8", "replace")
        except BlockingIOError:
            time.sleep(0.01)
        finally:
            os.set_blocking(self.terminal, True)


def environment(here: Path) -> dict[str, str]:
    """Return the environment of a shell whose home is a folder, and that finds the program of this Python."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return {"PATH": path, "HOME": str(here), "TERM": "xterm", "LC_ALL": "C.UTF-8", "ROSORIN_COMPILE_CACHE": "off"}


@contextmanager
def shell(name: str, here: Path, script: Sequence[str] = ()) -> Iterator[Shell]:
    """Run a shell in a folder, in which the completion is installed as its page says."""
    terminal, other_end = os.openpty()
    process = subprocess.Popen(
        _CALLS[name], cwd=here, env=environment(here), stdin=other_end, stdout=other_end, stderr=other_end,
        start_new_session=True,
    )  # fmt: skip
    os.close(other_end)
    made = Shell(terminal, here)
    try:
        start = here / ".start"
        start.write_text("\n".join([_START[name], f"source <(rosorin-compile completion {name})", *script]) + "\n")
        made.send(f"source {shlex.quote(str(start))}; echo be''gun\n")
        made.until("begun")
        made.until("ready> ")
        yield made
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        os.close(terminal)
