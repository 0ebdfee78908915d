"""Run the command line, as a program and as ``python -m rosorin_compile``."""

import gc


def program() -> int:
    """Run the command line and return the exit code, which is 130 after a Ctrl-C."""
    gc.disable()  # garbage collection takes time and frees little in a short run
    try:
        from rosorin_compile.cli.main import main as run

        return run()
    except KeyboardInterrupt:
        return 130
    finally:
        gc.freeze()  # otherwise, Python collects garbage at the end of the process


if __name__ == "__main__":
    raise SystemExit(program())
