"""Trust in the code that files of a robot execute.

Trust comes from the person who runs the command: an option, an environment variable, or a list of digests in the
configuration folder of the user. A description cannot grant it.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from pathlib import Path

VARIABLE = "ROSORIN_COMPILE_TRUST"  # 1: trust all files
LIST = Path("rosorin-compile", "trusted")  # in the configuration folder of the user


def untrusted(files: Iterable[Path]) -> list[Path]:
    """Return the files that are trusted neither by the environment variable nor by a digest in the user's list.

    Each line of the list begins with the SHA-256 digest of a file, as ``sha256sum`` prints it. A file that cannot be
    read is not trusted.
    """
    if os.environ.get(VARIABLE) == "1":
        return []
    digests = _digests()
    return [file for file in files if not digests or _digest(file) not in digests]


def _digests() -> set[str]:
    base = Path(os.environ.get("XDG_CONFIG_HOME", ""))
    folder = base if base.is_absolute() else Path("~/.config").expanduser()
    try:
        lines = (folder / LIST).read_text("utf-8").splitlines()
    except (OSError, ValueError):
        return set()
    return {line.split()[0].lower() for line in lines if line.strip() and not line.startswith("#")}


def _digest(file: Path) -> str:
    try:
        return hashlib.sha256(file.read_bytes()).hexdigest()
    except OSError:
        return ""
