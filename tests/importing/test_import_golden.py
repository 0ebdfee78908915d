"""What import makes of whole robots: the files that a person would have written, committed and compared to the byte.

    python tests/renew.py imported

writes them anew; read the difference. ``expected`` is what import writes, ``flat`` what it writes with ``--no-parts``,
where a robot has that folder.
"""

import sys

import pytest

from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.importing.elements.convert import with_sections
from rosorin_compile.importing.round_trip import check_round_trip
from support.paths import IMPORTED

FOLDER = IMPORTED
ROBOTS = sorted(path.name for path in FOLDER.iterdir() if path.is_dir())
EXPECTED, FLAT = "expected", "flat"
FOLDERS = [(name, EXPECTED) for name in ROBOTS] + [(name, FLAT) for name in ROBOTS if (FOLDER / name / FLAT).is_dir()]


def imported(name: str, folder: str = EXPECTED) -> dict[str, str]:
    made = read_robot(FOLDER / name / f"{name}.urdf")
    assert made.tree is not None, made.diagnostics
    said = with_sections(made)
    trip = check_round_trip(said.imported, FOLDER / name / folder, parts=folder == EXPECTED, plain=said.plain)
    assert trip.diagnostics == []
    return trip.files


@pytest.mark.parametrize(("name", "folder"), FOLDERS)
def test_files_are_those_that_are_committed(name: str, folder: str) -> None:
    expected = {path.name: path.read_text("utf-8") for path in (FOLDER / name / folder).iterdir()}
    assert imported(name, folder) == expected


def rewrite(name: str, folder: str) -> None:
    for path in (FOLDER / name / folder).glob("*.yaml"):
        path.unlink()
    for file, text in imported(name, folder).items():
        path = FOLDER / name / folder / file
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, "utf-8")


if __name__ == "__main__":
    for each, kind in FOLDERS:
        if not sys.argv[1:] or each in sys.argv[1:]:
            rewrite(each, kind)
