"""Run the command line as ``python -m rosorin_compile``."""

from .cli import main

if __name__ == "__main__":
    raise SystemExit(main())
