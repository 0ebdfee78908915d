"""The files that Git has staged for the next commit, as a folder."""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_SUBMODULE = "160000"


class NotStaged(Exception):
    """Git cannot tell what is staged; the text says why."""


@contextmanager
def staged_files(here: Path) -> Iterator[Path]:
    """Check out the index of the repository that a folder is in; yield the copy of the folder.

    The copy is in a temporary folder, with links to the submodules. In a hook Git names the index of the commit at
    hand, which this uses. Raises NotStaged without Git or a repository, and for an index with conflicts.
    """
    top = Path(_git(here, "rev-parse", "--show-toplevel").removesuffix("\n"))
    entries = _git(top, "ls-files", "--stage", "-z").split("\0")[:-1]
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-staged-") as temporary:
        copy = Path(os.path.realpath(temporary))
        _git(top, "checkout-index", "--all", "--force", "--quiet", f"--prefix={copy}{os.sep}")
        for entry in entries:
            mode, _, name = entry.partition(" ")[0], *entry.partition("\t")[1:]
            if mode == _SUBMODULE:
                (copy / name).parent.mkdir(parents=True, exist_ok=True)
                (copy / name).symlink_to(top / name, target_is_directory=True)
        folder = copy / Path(os.path.realpath(here)).relative_to(os.path.realpath(top))
        folder.mkdir(parents=True, exist_ok=True)
        yield folder


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    try:
        done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603 - the user's own Git
    except FileNotFoundError:
        raise NotStaged("Git is not installed") from None
    if done.returncode:
        raise NotStaged(os.fsdecode(done.stderr).strip().splitlines()[0] if done.stderr.strip() else "Git failed")
    return os.fsdecode(done.stdout)
