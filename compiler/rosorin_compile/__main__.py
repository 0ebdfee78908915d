"""Run the command line, as a program and as ``python -m rosorin_compile``."""

import gc


def program() -> int:
    """Run the command line; return the exit code, 130 after a Ctrl-C."""
    gc.disable()  # collection finds little to free in short runs
    try:
        from rosorin_compile.cli.main import main as run

        return run()
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    raise SystemExit(program())
