"""Run the command line, as a program and as ``python -m rosorin_compile``."""

from __future__ import annotations

import gc
import os
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
    gc.disable()  # nearly all that is made stays until the end
    from rosorin_compile.source.world import memory

    words = sys.argv[1:]
    done = memory.say_again(words)
    if done is not None:
        return done.code
    from rosorin_compile.cli.main import main as run

    try:
        signal.signal(signal.SIGINT, before)
        if not memory.is_asked_often(words):
            return run()
        return memory.once(memory.line(words), run)[0].code
    except KeyboardInterrupt:  # between the command and the memory of it
        return 130


def program() -> int:
    """Run the installed command, and end the process with it, without taking apart first what it holds.

    That takes Python a tenth of a short run. With numpy there may be libraries that still hold lines of their own: then
    it ends as any other.
    """
    code = main()
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # all is said: from here on it ends in silence, too
    if "numpy" in sys.modules:
        return code
    try:
        if "threading" in sys.modules:
            sys.modules["threading"]._shutdown()  # as Python itself: waits for those that must end
        if "atexit" in sys.modules:
            sys.modules["atexit"]._run_exitfuncs()
        sys.stdout.flush()
        sys.stderr.flush()
    except Exception:  # Python has words and a code for it
        return code
    os._exit(code)


if __name__ == "__main__":
    raise SystemExit(main())
