"""Where things are in the checkout: every test that reads a file of it asks here."""

from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent

COMPILER = ROOT / "compiler"
PACKAGE = COMPILER / "rosorin_compile"
# The core, and the packages beside it.
PACKAGES = sorted(path for path in COMPILER.glob("rosorin_compile*") if (path / "__init__.py").exists())
SCHEMAS = ROOT / "schemas"
DOCS = ROOT / "docs"
ROSORIN = ROOT / "descriptions" / "rosorin" / "robot.yaml"
OUTPUTS = ROOT / "outputs" / "rosorin"

# Cases: what a test makes of each file or folder stands in tests/README.md.
DATA = TESTS / "data"
BAD = TESTS / "bad"
BROKEN_SOURCES = TESTS / "broken_sources"
IMPORTED = TESTS / "imported"
ROUND_TRIP = TESTS / "round_trip"
XACRO = TESTS / "xacro"


def data_text(name: str) -> str:
    """Return the text of a file in ``tests/data``."""
    return (DATA / name).read_text("utf-8")
