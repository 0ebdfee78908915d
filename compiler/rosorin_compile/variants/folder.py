"""The output folder of a sweep: a subfolder per variant, ``sweep.json``, and a hidden folder with a record per variant.

The folder of a variant is replaced atomically, so that it is complete even if this process is killed. The record of a
variant, with the digests of its inputs and artifacts, is written last.
"""

import filecmp
import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from rosorin_compile.output.artifact_set import write_set
from rosorin_compile.output.atomic_files import OutputError, digest, entries_below, lock, may_replace, staging_folder
from rosorin_compile.source import system

INDEX = "sweep.json"
_NO_LOCKS = "this system has no file locks (fcntl): nothing keeps another run from writing into the same folder"


class VariantsFolder:
    """The output folder of a sweep. The methods raise OutputError, or OSError if the folder is not writable."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._hidden = path / ".rosorin-compile-sweep"
        self._records = self._hidden / "records"

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Create the output folder of a sweep, and lock it for the ``with`` block."""
        self._records.mkdir(parents=True, exist_ok=True)
        system.needs("fcntl", _NO_LOCKS)
        with (self._hidden / "lock").open("ab") as lock_file:
            try:
                import fcntl

                # Do not use flock, because worker processes inherit its locks, and may outlive a killed run.
                fcntl.lockf(lock_file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except (BlockingIOError, PermissionError):
                message = f"another run writes into {self.path}"
                raise OutputError("output-busy", message, "wait until it ends, or name another folder") from None
            except (ImportError, OSError):
                pass  # Windows and some network drives do not support locks
            with suppress(FileNotFoundError), (self.path / INDEX).open("rb") as file:
                if file.read(10) not in (b'{"sweep": ', b""):
                    raise _not_ours(self.path / INDEX)
            with lock(self.path, tidy=True):
                pass
            yield

    def names(self) -> list[str]:
        """Return the names of the variants in the folder."""
        return sorted(path.stem for path in self._records.glob("*.json"))

    def record(self, name: str) -> dict[str, Any]:
        """Read the record of a variant (digests, entry of ``sweep.json``); return an empty record if it is invalid."""
        try:
            record = json.loads((self._records / f"{name}.json").read_bytes())
            entry = {**record["entry"], "artifacts": dict(record["entry"]["artifacts"])}
            return {"key": record["key"], "inputs": dict(record["inputs"]), "entry": entry}
        except (OSError, ValueError, KeyError, TypeError):
            return {"key": "", "inputs": {}, "entry": {"artifacts": {}}}

    def is_intact(self, name: str, artifacts: Mapping[str, str]) -> bool:
        """Return True if a variant has all files in ``artifacts``, with unchanged contents (digests by file name)."""
        with suppress(OSError):
            return all(digest((self.path / name / file).read_bytes()) == d for file, d in artifacts.items())
        return False

    def put(self, name: str, files: Mapping[str, bytes], record: Mapping[str, Any]) -> None:
        """Write the artifacts and the record of a variant, remove old artifacts, and keep other files in its folder."""
        folder, known = self.path / name, set(self.record(name)["entry"]["artifacts"])
        if os.path.lexists(folder) and (folder.is_symlink() or not folder.is_dir()):
            raise OutputError("output-in-the-way", f"{folder} is not a folder", "move it away, or rename the variant")
        for path, data in ((folder / file, data) for file, data in files.items() if file not in known):
            is_ours = path.is_file() and not path.is_symlink() and (may_replace(path) or path.read_bytes() == data)
            if os.path.lexists(path) and not is_ours:
                raise _not_ours(path)
        # If this process is killed after this line, the next run treats both old and new files as artifacts.
        artifacts = dict.fromkeys(sorted(known | set(files)), "")
        self._write_record(name, {"key": "", "inputs": {}, "entry": {"artifacts": artifacts}})
        if files:
            write_set(folder, files, durable=False)
        self._remove(folder, known - set(files))
        self._write_record(name, record)

    def drop(self, name: str) -> None:
        """Remove the artifacts and the record of a variant."""
        if (self._records / f"{name}.json").is_file():
            (self.path / INDEX).unlink(missing_ok=True)  # the index is no longer valid
            self._remove(self.path / name, set(self.record(name)["entry"]["artifacts"]))
            (self._records / f"{name}.json").unlink()

    def _remove(self, folder: Path, names: set[str]) -> None:
        """Remove files of a variant, in one step if the folder contains no other files."""
        if not names or not folder.is_dir():
            return
        if all(name in names or entry.is_dir(follow_symlinks=False) for name, entry in entries_below(folder)):
            with lock(self.path), staging_folder(self.path) as stage:
                folder.rename(stage / "removed")
            return
        for path in (folder / name for name in names if ".." not in Path(name).parts):
            path.unlink(missing_ok=True)
            with suppress(OSError):  # keep folders that are not empty
                for parent in path.relative_to(self.path).parents[:-1]:
                    (self.path / parent).rmdir()

    def _write_record(self, name: str, record: Mapping[str, Any]) -> None:
        (self.path / INDEX).unlink(missing_ok=True)  # the index is no longer valid
        new = self._hidden / "new-record.json"
        new.write_text(json.dumps(record), "utf-8")
        new.replace(self._records / f"{name}.json")

    @contextmanager
    def index(self, head: Mapping[str, object]) -> Iterator[Callable[[Mapping[str, Any]], object]]:
        """Write ``sweep.json``: yield a function that adds the entry of a variant, and replace the file on exit."""
        new, place, before = self._hidden / "new-index.json", self.path / INDEX, iter(["\n"])
        with new.open("w", encoding="utf-8", newline="\n") as file:
            file.write(json.dumps({"sweep": 1, **head})[:-1] + ', "variants": [')
            yield lambda entry: file.write(next(before, ",\n") + json.dumps(entry))
            file.write("\n]}\n")
        if not place.is_file() or not filecmp.cmp(place, new, shallow=False):
            new.replace(place)
        new.unlink(missing_ok=True)


def _not_ours(path: Path) -> OutputError:
    message, help = f"this tool did not write {path}: it is not replaced", "move it away, or name another folder"
    return OutputError("output-not-ours", message, help)
