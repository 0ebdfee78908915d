"""Write files into a folder that also contains other files, such as a ROS package.

Each file is replaced atomically. A manifest in the folder has the SHA-256 digest of each written file. While files are
being replaced, it has the old and the new digest, so that both versions can be recognized after a killed process.
"""

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from rosorin_compile.source.load import json_of

from .artifact_set import is_inside, obstacle
from .atomic_files import OutputError, digest, lock, replace_files, replace_folder, staging_folder, write_files

MANIFEST = ".rosorin-compile-written.json"


class PackageFolder:
    """A folder into which files are written; ``is_new`` is True if the folder does not exist yet."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_new = not path.is_dir()
        self._manifest = read_manifest(path)

    def digests(self) -> dict[str, list[str]]:
        """Return the digests of each file: one, or the old and the new one if a process was killed while writing."""
        return {name: [value] if isinstance(value, str) else value for name, value in self._manifest.items()}

    def check_name(self, name: str) -> None:
        """Raise OutputError if a path leaves the folder, is below a symlink, or exists but is not a regular file."""
        if not is_inside(name):
            raise OutputError("deploy-outside", f'"{name}" is not below the folder', "name a file below the folder")
        path, kind = obstacle(self.path, name) or (self.path, "")
        if kind == "a symbolic link":
            message = f"{path} is a symbolic link to {path.readlink()}; nothing is written through links"
            raise OutputError("deploy-link", message, "name the folder that it leads to, or remove the link")
        if kind:
            message = f"{path} is not {'a file' if path == self.path / name else 'a folder'}"
            raise OutputError("deploy-in-the-way", message, "move it away, or choose another place")

    def write(
        self, files: Mapping[str, bytes], unlisted: Mapping[str, bytes] | None = None, manifest: bool = True
    ) -> tuple[str, ...]:
        """Write ``files`` in their order, and then the manifest; return the changed files, sorted.

        ``unlisted`` files are written first, and are not in the manifest. If a file cannot be written, the folder is
        left unchanged and OutputError is raised.
        """
        contents = {**(unlisted or {}), **files}
        for name in contents:
            self.check_name(name)
        try:
            before = {name: _content(self.path / name) for name in contents}
            changed = {name: data for name, data in contents.items() if data != before[name]}
            listed = {name for name in self._manifest if name in files or (self.path / name).is_file()}
            if any(name not in files and not isinstance(self._manifest[name], str) for name in listed):
                listed |= self._manifest.keys()  # keep files of a killed process in the manifest
            final = {name: self._manifest[name] for name in listed} | {n: digest(data) for n, data in files.items()}
            last = {MANIFEST: _manifest_text(final)} if manifest else {}
            if self.is_new:
                replace_folder(self.path, {**contents, **last})
            elif changed or (last and _content(self.path / MANIFEST) != last[MANIFEST]):
                for name in (n for n in files if n in changed or not isinstance(self._manifest.get(n, ""), str)):
                    final[name] = [digest(data) for data in (before[name], files[name]) if data is not None]
                first = {name: data for name, data in changed.items() if name not in files}
                unfinished = dict.fromkeys(last, _manifest_text(final))
                steps = {**first, **unfinished, **{name: files[name] for name in files if name in changed}}
                with staging_folder(self.path) as stage:
                    write_files(stage / "new", steps, self.path)
                    write_files(stage / "last", last, self.path)
                    if any(_content(self.path / name) != before[name] for name in changed):
                        message = f"a file in {self.path} was changed just now: nothing is written"
                        raise OutputError("deploy-failed", message, "run the command again")
                    replace_files(stage / "new", self.path, stage / "undo", list(steps))
                    for name in last:
                        (stage / "last" / name).replace(self.path / name)
            return tuple(sorted(changed))
        except OSError as problem:
            raise _failed(problem, self.path) from None


@contextmanager
def open_package_folder(folder: Path, dry_run: bool = False) -> Iterator[PackageFolder]:
    """Yield a ``PackageFolder``, locked in the ``with`` block unless ``dry_run`` is True. Raises OutputError."""
    with ExitStack() as stack:
        try:
            path = folder.resolve()
            if path.exists() and not path.is_dir():
                raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), str(path))
            if not dry_run:
                path.parent.mkdir(parents=True, exist_ok=True)
                with suppress(OSError), lock(path.parent, tidy=True):
                    pass  # locking with ``tidy`` removes leftovers of killed processes
                stack.enter_context(lock(path if path.is_dir() else path.parent, tidy=True))
            package = PackageFolder(path)
        except OSError as problem:
            raise _failed(problem, folder) from None
        yield package


def _content(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None


def read_manifest(folder: Path) -> dict[str, str | list[str]]:
    """Return {file: digest}, with [old digest, new digest] after a killed process; {} without a valid manifest."""
    try:
        values = json_of((folder / MANIFEST).read_bytes())
    except (OSError, ValueError):
        return {}

    def is_valid(value: object) -> bool:
        return isinstance(value, str) or (isinstance(value, list) and value != [] and all(map(is_valid, value)))

    return {n: v for n, v in values.items() if is_valid(v)} if isinstance(values, dict) else {}


def _manifest_text(digests: Mapping[str, str | list[str]]) -> bytes:
    return json.dumps(digests, indent=1, sort_keys=True).encode() + b"\n"


def _failed(problem: OSError, folder: Path) -> OutputError:
    place = problem.filename if isinstance(problem.filename, str) else folder
    message = f"cannot write into {folder}: {problem.strerror or type(problem).__name__} ({place})"
    return OutputError("deploy-failed", message, "give yourself the right to write there, or name another folder")
