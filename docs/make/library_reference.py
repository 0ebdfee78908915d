"""Generate the page on the library of parts from the files of the library.

    python docs/make/library_reference.py > docs/parts-library.md

``python tests/renew.py docs`` does that too. The text before the parts is in ``docs/_library_head.md``.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.source.load import load_mapping
from rosorin_compile.source.units import Quantity

LIBRARY = Path(__file__).parents[2] / "parts"
HEAD = Path(__file__).parents[1] / "_library_head.md"

TITLES = {"solids": "Bodies", "wheels": "Wheels", "servos": "Servos", "sensors": "Sensor types"}
_SECTIONS = ("links", "joints", "servos")
_NAME = re.compile(r"\$\{(\w+)\}")


def text() -> str:
    """Return the page as it is committed."""
    lines = [HEAD.read_text("utf-8").rstrip()]
    for name, title in TITLES.items():
        file = load_mapping(LIBRARY / f"{name}.yaml", f"{name}.yaml")
        lines += ["", f"## {title}", "", str(file["help"]).strip()]
        for part, body in file.get("parts", {}).items():
            lines += ["", f"### {name}/{part}", "", *_part(body)]
        for kind, body in file.get("sensor_types", {}).items():
            lines += ["", f"### {kind}", "", *_sensor_type(body)]
    return "\n".join([*lines, ""])


def _part(body: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines on a part: what it is, its arguments, what it makes."""
    yield from (str(body["help"]), "", *_parameters(body.get("params") or {}), "")
    made = [
        f"{section}: {', '.join(f'`NAME_{_plain(name)}`' for name in body[section])}"
        for section in _SECTIONS
        if body.get(section)
    ]
    yield f"Makes {'; '.join(made)}."


def _sensor_type(body: Mapping[str, Any]) -> Iterator[str]:
    """Yield the lines on a type of sensor: what it is, its arguments, its frames, what simulators have of it."""
    yield str(body["help"])
    if body.get("params"):
        yield from ("", *_parameters(body["params"]))
    optical = body.get("optical")
    frames = "its `frame`" + (f", and the optical frame `{_plain(optical['frame'])}`" if optical else "")
    elements = [_element(entry) for entry in body.get("mjcf") or ()]
    seen = ", ".join(str(entry["sensor"]) for entry in body.get("gazebo") or ())
    yield from ("", f"Frames: {frames}. In MuJoCo: {', '.join(elements)}. In Gazebo: {seen or 'nothing'}.")


def _element(entry: Mapping[str, Any]) -> str:
    """Return an element of MJCF by its name and what it is."""
    name = "NAME" + (f"_{_plain(str(entry['name']))}" if "name" in entry else "")
    numbered = "_NUMBER" if "replicate" in entry else ""
    kind = entry.get("sensor") or entry.get("body")
    return f"{kind} `{name}{numbered}`" + (" (optional)" if "if" in entry else "")


def _parameters(params: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of arguments."""
    yield "| argument | type | default | meaning |"
    yield "|---|---|---|---|"
    for name, entry in params.items():
        given = entry if isinstance(entry, Mapping) else {"default": entry}
        kind = str(given.get("type", "any")).replace("_", " ")
        if "one_of" in given:
            kind = ", ".join(f"`{option}`" for option in given["one_of"])
        cells = (f"`{name}`", kind + _bounds(given), _default(given), str(given.get("help", "")).replace("*", r"\*"))
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


def _bounds(given: Mapping[str, Any]) -> str:
    low, high = given.get("min"), given.get("max")
    if low is None and high is None:
        return ""
    return f", {_value(low)} to {_value(high)}" if high is not None else f", at least {_value(low)}"


def _default(given: Mapping[str, Any]) -> str:
    if "default" not in given:
        return "**required**"
    default = given["default"]
    if default in ("${none}", ""):
        return "none" if default else "empty"
    return f"`{_value(default)}`"


def _value(value: Any) -> str:
    """Return a value as it is written in YAML."""
    if isinstance(value, Quantity):
        return value.text
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return str(value).lower() if isinstance(value, bool) else str(value)


def _plain(name: str) -> str:
    """Return a name with its expressions as words in capitals."""
    return _NAME.sub(lambda found: found[1].upper(), name)


if __name__ == "__main__":
    sys.stdout.write(text())
