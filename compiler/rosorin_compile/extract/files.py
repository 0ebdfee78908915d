"""Files that extract writes one by one: whole or not at all, and never over something that somebody else wrote."""

from __future__ import annotations

import os
import secrets
from contextlib import suppress
from pathlib import Path

from ..registry import MESHES, Rule
from .problems import fail

RULES = (
    Rule(
        "extract-file",
        "A result cannot be written, or would overwrite a file that `extract` did not make.",
        "Another name, or `--force`.",
        MESHES,
    ),
)

# The first words of every file that extract writes.
MARK = "# rosorin-compile extract"


def save(path: Path, text: str, force: bool = False) -> None:
    """Write a file; one that extract did not make is overwritten only with ``force``. Raises ExtractProblem."""
    if not force and os.path.lexists(path) and not _is_ours(path):
        message = f"{path} is there, and extract did not make it"
        raise fail("extract-file", message, "name another file, or add --force")
    replace(path, text)


def replace(path: Path, text: str) -> None:
    """Put a new text into a file: after a kill at any moment it holds the old or the new one. Raises ExtractProblem.

    A link stays a link, and permissions stay as they are.
    """
    target = Path(os.path.realpath(path))
    stage = target.with_name(f".rosorin-compile-{secrets.token_hex(8)}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with stage.open("xb") as file:
            file.write(text.encode("utf-8"))
            file.flush()
            os.fsync(file.fileno())
        if target.exists():
            stage.chmod(target.stat().st_mode & 0o7777)
        stage.replace(target)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        help = "check the name and the permissions"
        raise fail("extract-file", f"cannot write {path}: {reason}", help) from None
    finally:
        with suppress(OSError):
            stage.unlink()


def _is_ours(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(len(MARK) + 1)
    except OSError:
        return False
    return head.startswith(MARK.encode())
