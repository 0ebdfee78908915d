"""Papers: what a package of ROS brings along that no robot needs to run: licence, changelog, and a test.

Licence and changelog are people's from then on: what stands there and is not as it was written is left alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosorin_compile.output import digest
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.files import is_file, read_bytes
from rosorin_compile.source.rule_registry import Heading, Rule

if TYPE_CHECKING:
    from .package import Options

RULES = (
    Rule(
        "package-defaults",
        "A note: the maintainer of the package, or its licence, is not stated.",
        "`--maintainer`, `--license`",
        Heading.PACKAGES,
    ),
    Rule(
        "package-license",
        "A note: the text of the licence is not one that the tool carries, so that there is no LICENSE.",
        "Put the text into the file LICENSE of the package.",
        Heading.PACKAGES,
    ),
)

LICENSE, CHANGELOG, TEST = "LICENSE", "CHANGELOG.rst", "test/test_urdf.py"
LICENSES = ("Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "MIT")  # by SPDX; their texts are templates
NOBODY, NO_LICENSE = "nobody yet", "LicenseRef-not-stated"
NO_MAIL = "nobody@example.com"


def templates(options: Options) -> dict[str, str]:
    """Return the templates of the papers, by the names of the files."""
    papers = {CHANGELOG: "CHANGELOG.rst", TEST: "test_urdf.py"}
    return papers | ({LICENSE: f"licenses/{options.license}"} if options.license in LICENSES else {})


def values(options: Options, target: Path) -> dict[str, Any]:
    """Return what their templates need to know."""
    holder = f"the authors of {options.name}" if options.maintainer == NOBODY else options.maintainer
    has_license = options.license in LICENSES or is_file(target / LICENSE)
    return {"holder": holder, "license_file": LICENSE if has_license else ""}


def left_alone(target: Path, files: Mapping[str, bytes], record: Mapping[str, list[str]]) -> set[str]:
    """Return which papers in a folder are people's: those that are not as we wrote them, by the digests in ``record``.

    Raises OSError.
    """
    papers = [name for name in (CHANGELOG, LICENSE) if name in files and is_file(target / name)]
    return {name for name in papers if digest(read_bytes(target / name)) not in record.get(name, ())}


def remarks(options: Options, target: Path) -> list[Diagnostic]:
    """Return what the papers say by default and their reader should decide."""
    found = []
    said = (("--maintainer", options.email != NO_MAIL), ("--license", options.license != NO_LICENSE))
    undecided = [option for option, is_said in said if not is_said]
    if undecided:
        message = (
            f"package.xml does not say yet who maintains the package or how it is licensed ({', '.join(undecided)})"
        )
        help = "--maintainer 'NAME <MAIL>', --license with an SPDX name such as Apache-2.0"
        found.append(Diagnostic("package-defaults", NOTE, message, None, (), help))
    if options.license not in (*LICENSES, NO_LICENSE) and not is_file(target / LICENSE):
        message = f"there is no LICENSE in the package: the tool does not carry the text of {options.license}"
        help = f"put the text of the licence into {target / LICENSE}; it stays there"
        found.append(Diagnostic("package-license", NOTE, message, None, (), help))
    return found
