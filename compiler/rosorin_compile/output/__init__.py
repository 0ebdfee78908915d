"""Write files: the artifacts of a robot as one set, files of a package, and single files."""

# fmt: off
# isort: off
from .artifact_set import (
    Judge, WriteResult, check_names, encode, is_remembered, read_set, remember, write_artifacts, write_set,
)
from .atomic_files import (
    OutputError, digest, entries_below, is_generated, kept_name, lock, may_replace, staging_folder, write_file,
)
from .package_folder import MANIFEST, PackageFolder, open_package_folder, read_manifest

__all__ = [
    "MANIFEST", "Judge", "OutputError", "PackageFolder", "WriteResult", "check_names", "digest", "encode",
    "entries_below", "is_generated", "is_remembered", "kept_name", "lock", "may_replace", "open_package_folder",
    "read_manifest", "read_set", "remember", "staging_folder", "write_artifacts", "write_file", "write_set",
]
# isort: on
# fmt: on
