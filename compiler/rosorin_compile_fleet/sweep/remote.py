"""Remote: a folder of variants where fsspec leads: s3://, gs://, file:// on a drive that many machines share.

As ``variants``, but for what such a place cannot do: it renames no folder and has no hard links. So a variant counts
as made when its record says by what, which is written last. Before that, the record says which files are ours, so that
half of a variant is known, too, and the index does not have it. Equal artifacts are copies, artifacts are not read
again to see whether somebody edited them, and nothing keeps two runs apart: both would write the same.
"""

from __future__ import annotations

import errno
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from rosorin_compile.diagnostics import pip_install
from rosorin_compile.extending import Holding, OutputError, world

from .folder import BEGIN, HIDDEN, INDEX, Record, Stored, VariantsFolder, unfinished


def is_remote(name: str) -> bool:
    """Say whether the name of a folder is an address for fsspec."""
    return "://" in name


def folder_of(name: str) -> VariantsFolder | RemoteFolder:
    """Return the folder of variants of a name or an address. Raises OutputError."""
    return RemoteFolder(name) if is_remote(name) else VariantsFolder(Path(name))


class RemoteFolder:
    """A folder of variants at an address, for one process of a run."""

    def __init__(self, address: str) -> None:
        self.address = address
        self.base = Path("/")
        self.lock = None
        try:
            made = import_module("fsspec.core").url_to_fs(address)
        except (ImportError, ValueError) as problem:
            known = isinstance(problem, ImportError)
            help = f"{pip_install('dask')}, and what fsspec asks for" if known else "such as s3://BUCKET/FOLDER"
            raise OutputError("output-folder", f"cannot write to {address}: {problem}", help) from None
        self.files: Any = made[0]
        self.root: str = made[1].rstrip("/")

    def place(self, name: str) -> Path:
        """Return where the artifacts of a variant would stand if they stood here."""
        return Path(HIDDEN, name)

    def named(self, path: Path) -> str:
        """Return how a file is called in the index."""
        return world.shown(path)

    def explained(self, problem: OSError) -> OutputError:
        """Return the error for a user when something cannot be read or written."""
        reason = problem.strerror or str(problem) or type(problem).__name__
        help = (
            "make the bucket, or correct the address"
            if isinstance(problem, FileNotFoundError)
            else "the same command goes on"
        )
        return OutputError("output-failed", f"cannot write to {self.address}: {reason}", help)

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Make the folder. Raises OutputError, OSError."""
        with _as_os_error(self.address):
            if self._may_make_folders():
                self.files.makedirs(f"{self.root}/{HIDDEN}", exist_ok=True)
            data = self._read(INDEX)
            if data is not None and not data.startswith(BEGIN):
                message = f"this tool did not write {self.address}/{INDEX}: it is not replaced"
                raise OutputError("output-not-ours", message, "move it away, or name another folder")
        yield

    @contextmanager
    def working(self) -> Iterator[None]:
        """Do as a local folder does."""
        yield

    def names(self) -> Iterator[str]:
        """Yield the names of the variants of which there is a record, in no order. Raises OSError."""
        with _as_os_error(self.address):
            found = self._below(f"{HIDDEN}/records")
        for path in found:
            yield path.rpartition("/")[2].removesuffix(".json")

    def index(self) -> RemoteIndex:
        """Return what writes the index of all variants."""
        return RemoteIndex(self)

    def record(self, name: str) -> Record | None:
        """Return what is known of a variant; None if nothing is, or its record is damaged."""
        try:
            known = json.loads(self._read(_record(name)) or b"null")
            return Record(str(known["key"]), str(known["made_of"]), int(known["at"]), str(known["line"]))
        except (ValueError, KeyError, TypeError):
            return None

    def holds(self, name: str, artifacts: Mapping[str, str]) -> bool:
        """Say whether the folder of a variant has files of these names."""
        with _as_os_error(self.address):
            return bool(artifacts) and artifacts.keys() <= set(self._below(name))

    def put(self, name: str, files: Mapping[str, bytes], record: Record | None) -> None:
        """Make ``files`` the artifacts of a variant; its record comes first, and is whole at last. Raises OSError."""
        with _as_os_error(self.address):
            before = self.record(name)
            known = before.artifacts if before else {}
            there = self._below(name)
            for file in files:
                if file in there and file not in known:
                    self._check_ours(f"{name}/{file}", files[file])
            if record is not None:
                self._remember(name, unfinished(record, before))
            self._write({f"{name}/{file}": data for file, data in files.items()})
            for file in known:
                if file not in files and file in there:
                    self.files.rm_file(f"{self.root}/{name}/{file}")
            if record is not None:
                self._remember(name, record)
            elif before is not None:
                self.files.rm_file(f"{self.root}/{_record(name)}")

    def _remember(self, name: str, record: Record) -> None:
        self._write({_record(name): json.dumps(record._asdict()).encode()})

    def drop(self, name: str) -> None:
        """Remove the artifacts of a variant that there is to be no more. Raises OSError."""
        self.put(name, {}, None)

    def sweep_up(self) -> Stored:
        """Return nothing of what is stored: nobody counts it here."""
        return Stored(0, 0)

    def keep_made_of(self, files: Mapping[str, Any]) -> str:
        """Keep what a variant was made of, plain JSON; return the name under which it is known. Raises OSError."""
        data = json.dumps(files, sort_keys=True).encode()
        known = Holding.digest(data)
        with _as_os_error(self.address):
            place = f"{HIDDEN}/made_of/{known}.json"
            if not self.files.exists(f"{self.root}/{place}"):
                self._write({place: data})
        return known

    def made_of(self, known: str) -> dict[str, Any] | None:
        """Return what is kept under a name; None if that is nothing."""
        try:
            data = self._read(f"{HIDDEN}/made_of/{known}.json") or b"null"
            found = json.loads(data) if Holding.digest(data) == known else None
        except ValueError:
            return None
        return found if isinstance(found, dict) else None

    def _below(self, name: str) -> list[str]:
        """Return the files below a folder, as they are now: other processes write, too."""
        place = f"{self.root}/{name}"
        self.files.invalidate_cache(place)
        try:
            return [str(path).removeprefix(place).lstrip("/") for path in self.files.find(place)]
        except FileNotFoundError:
            return []

    def _check_ours(self, name: str, new: bytes) -> None:
        old = self._read(name) or b""
        if old != new and not Holding.is_marked(old) and old.strip():
            message = f"this tool did not write {self.address}/{name}: it is not replaced"
            raise OutputError("output-not-ours", message, "move it away, or name another folder")

    def _read(self, name: str) -> bytes | None:
        try:
            data: bytes = self.files.cat_file(f"{self.root}/{name}")
        except FileNotFoundError:
            return None
        return data

    def _write(self, files: Mapping[str, bytes]) -> None:
        """Write files, at once where the place can do that."""
        placed = {f"{self.root}/{name}": data for name, data in files.items()}
        try:
            self.files.pipe(placed)
        except FileNotFoundError:
            if not self._may_make_folders():
                raise
            for folder in {place.rpartition("/")[0] for place in placed}:
                self.files.makedirs(folder, exist_ok=True)
            self.files.pipe(placed)

    def _may_make_folders(self) -> bool:
        """Say whether making folders here makes no bucket: its name could be a slip, and it costs."""
        bucket = self.root.partition("/")[0]
        return not bucket or bool(self.files.exists(bucket))


class RemoteIndex:
    """Writes the index of all variants into a file here, which is sent when all is done."""

    def __init__(self, folder: RemoteFolder) -> None:
        import tempfile

        self.folder = folder
        self.file = tempfile.TemporaryFile()  # noqa: SIM115 - as long as the run

    def write(self, text: str) -> None:
        """Add some text. Raises OSError."""
        self.file.write(text.encode())

    def outdate(self) -> None:
        """Take the old index away: from now on the variants are not as it says. Raises OSError."""
        with _as_os_error(self.folder.address), suppress(FileNotFoundError):
            self.folder.files.rm_file(f"{self.folder.root}/{INDEX}")

    def close(self) -> None:
        """Send the index. Raises OSError."""
        import shutil

        self.file.seek(0)
        with _as_os_error(self.folder.address), self.folder.files.open(f"{self.folder.root}/{INDEX}", "wb") as there:
            shutil.copyfileobj(self.file, there)
        self.file.close()

    def leave(self) -> None:
        """Leave without an index: not all is done."""
        self.file.close()


def _record(name: str) -> str:
    return f"{HIDDEN}/records/{Holding.digest(name.encode())[:2]}/{name}.json"


@contextmanager
def _as_os_error(address: str) -> Iterator[None]:
    """Raise OSError for whatever the library of a place raises."""
    try:
        yield
    except (OSError, OutputError):
        raise
    except Exception as problem:
        raise OSError(errno.EIO, f"{type(problem).__name__}: {problem}", address) from None
