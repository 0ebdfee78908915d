"""What Gazebo makes of a URDF: libsdformat from Debian (libsdformat12-12), asked in a process of its own.

``as_sdf`` returns the SDF and what was said; ``known`` are the elements that the specification of SDF has.
"""

import ctypes
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

_NAME = "libsdformat12.so.12"
_TABLES = Path("/usr/share/sdformat12/1.9")
# It prints to the streams of its process, in colours.
_CHILD = f"""import ctypes, sys
library = ctypes.CDLL({_NAME!r})
library.cmdPrint.argtypes, library.cmdPrint.restype = [ctypes.c_char_p], ctypes.c_int
sys.exit(library.cmdPrint(sys.argv[1].encode()) & 1)
"""


def need() -> None:
    """Skip the test where the library is not installed."""
    try:
        ctypes.CDLL(_NAME)
    except OSError:
        pytest.skip(f"{_NAME} is not installed: apt-get install libsdformat12-12")


def as_sdf(urdf: str, folder: Path) -> tuple[ET.Element, str]:
    """Return the <model> that Gazebo reads out of a URDF, and all errors and warnings that it says."""
    path = folder / "judged.urdf"
    path.write_text(urdf, "utf-8")
    ran = subprocess.run([sys.executable, "-c", _CHILD, str(path)], capture_output=True, text=True, timeout=60)
    end = ran.stdout.find("</sdf>") + len("</sdf>")
    model = ET.fromstring(ran.stdout[ran.stdout.index("<sdf") : end]).find("model")
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert model is not None, ran.stdout
    said = ran.stderr + ran.stdout[: ran.stdout.index("<sdf")] + ran.stdout[end:]
    return model, "\n".join(line for line in said.splitlines() if re.search("error|warning", line, re.I))


def known(file: str) -> dict[str, dict]:
    """Return the elements within the one that a file of the specification describes, as nested tables."""
    return _table(ET.parse(_TABLES / f"{file}.sdf").getroot())


def _table(element: ET.Element) -> dict[str, dict]:
    found = {one.get("name"): _table(one) for one in element.findall("element") if one.get("name")}
    for one in element.findall("include"):
        path = _TABLES / one.get("filename")
        found[path.stem] = {}  # Debian's package lacks one of the files that it names
        if path.is_file():
            root = ET.parse(path).getroot()
            found[root.get("name")] = _table(root)
    return found


def said_of(path: Path) -> str:
    """Return what libsdformat says of an SDF, errors and warnings alone; it takes it for valid."""
    child = _CHILD.replace("cmdPrint", "cmdCheck")
    ran = subprocess.run([sys.executable, "-c", child, str(path)], capture_output=True, text=True, timeout=60)
    said = ran.stdout + ran.stderr
    assert ran.returncode == 0, said
    assert "Valid." in said
    return "\n".join(line for line in said.splitlines() if re.search("error|warning", line, re.I))
