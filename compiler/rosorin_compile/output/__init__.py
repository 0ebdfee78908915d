"""Write files: the artifacts of a robot as one set, files of a package, and single files."""

from .artifact_set import (
    Judge,
    WriteResult,
    check_names,
    encode,
    is_remembered,
    read_set,
    remember,
    write_artifacts,
    write_set,
)
from .package_folder import MANIFEST, PackageFolder, open_package_folder, read_manifest
from .single_file import OutputError, digest, is_generated, kept_name, may_replace, write_file
from .staging import entries_below, lock, staging_folder

__all__ = [
    "MANIFEST", "Judge", "OutputError", "PackageFolder", "WriteResult", "check_names", "digest", "encode",
    "entries_below", "is_generated", "is_remembered", "kept_name", "lock", "may_replace", "open_package_folder",
    "read_manifest", "read_set", "remember", "staging_folder", "write_artifacts", "write_file", "write_set",
]  # fmt: skip
