"""Run the command line, as a program and as ``python -m rosorin_compile``."""

from __future__ import annotations

import sys

try:
    # It is in the interpreter; a Ctrl-C can come while the other one imports enum.
    import _signal as signal  # type: ignore[import-not-found]
except ImportError:
    import signal


def main() -> int:
    """Run the command line; return the exit code. A Ctrl-C that comes before there is a command ends it in silence."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else somebody has said what it means
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from .startup.again import said_again

    if said_again(sys.argv[1:]):
        return 0
    from .cli import main as run

    signal.signal(signal.SIGINT, before)
    return run()


if __name__ == "__main__":
    raise SystemExit(main())
