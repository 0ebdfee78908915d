"""Where the code of the tool is."""

from pathlib import Path


def folders() -> dict[str, Path]:
    """Return the folder of the code of the tool, by the name of its package."""
    return {"rosorin_compile": Path(__file__).parents[1]}
