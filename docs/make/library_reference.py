"""The page on the library of parts, made from the files of the library, so that it cannot fall behind.

    python docs/make/library_reference.py > docs/parts-library.md

``python tests/renew.py docs`` does that too.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.extending import Map, Quantity

LIBRARY = Path(__file__).parents[2] / "parts"

TITLES = {"solids": "Bodies", "wheels": "Wheels", "servos": "Servos", "sensors": "Sensor types"}
_SECTIONS = ("links", "joints", "servos")
_NAME = re.compile(r"\$\{(\w+)\}")

_HEAD = """# The library of parts

<!-- Made by: python docs/make/library_reference.py > docs/parts-library.md. Edit parts/*.yaml or that module.
-->

Parts and types of sensors that ship with the tool. They are plain YAML, in the folder `parts` of the project: read
them when you write your own.

- A part is used by its file and name, `{part: wheels/fixed}`, and gets its arguments in `with`. What it makes is
  called like the use, here NAME, with `_` and the name in the part; `prefix` changes that.
- A sensor names its type, `{type: lidar_2d}`, and gives the arguments of the type in `with`.

An argument that is missing, unknown, of another kind or out of bounds is an error at the place where it stands."""

_INERTIA = """
## Mass and inertia of shapes

The inertia of a body needs no part. In any link, `of` takes centre of mass and inertia from shapes of even density:
from `collision`, from `visual`, or from a list that stands there. Give their `mass`, or their `density`.

<!-- file: descriptions/beam/robot.yaml -->
```yaml
robot: beam
links:
  base_link:
    inertial: {mass: 1.2 kg, of: collision}
    collision:
      - box: {size: [0.3, 0.2, 0.05]}
      - {cylinder: {radius: 40 mm, length: 0.1}, xyz: [0, 0, 75 mm]}
  beam:
    inertial:
      density: 2700 kg/m^3
      of:
        - box: {size: [0.5, 20 mm, 20 mm]}
        - {sphere: {radius: 25 mm}, xyz: [0.25, 0, 0]}
joints:
  weld: {type: fixed, parent: base_link, child: beam, xyz: [0, 0, 0.14]}
outputs:
  urdf: {file: beam.urdf}
```

Boxes, cylinders, spheres, capsules and height maps have a volume; of a mesh it is not known here. Where shapes
overlap, the overlap counts twice.
"""

_OWN = """
## A type of your own

A new type is YAML under `sensor_types`, beside `sensors`. It has `params`, `let`, and what every sensor of the type
gets unless it says otherwise: `optical`, `publisher`, `source`, `mjcf`, `gazebo` and `urdf_elements`. Its expressions
know `name`, `frame` and `parent` of the sensor. A number among the `params` may have bounds, `min` and `max`.

<!-- file: descriptions/mole/robot.yaml -->
```yaml
robot: mole
links:
  base_link: {}
sensor_types:
  sonar_ring:
    help: sonars all around
    params:
      count: {type: integer, default: 8, min: 2, max: 64, help: number of sonars}
      radius: {type: length, default: 100 mm, help: of the ring}
    mjcf:
      - sensor: rangefinder
        name: beam
        xyz: ["${radius}", 0, 0]
        rpy: [0, 90 deg, 0]
        replicate: {count: "${count}", rpy: [0, 0, "${360*deg / count}"]}
        attributes: {cutoff: 4}
  compass:
    params:
      rate: {type: frequency, default: 50 Hz}
    mjcf:
      - sensor: magnetometer
    gazebo:
      - sensor: magnetometer
        elements: {update_rate: "${rate}", topic: "${name}"}
sensors:
  ring: {type: sonar_ring, parent: base_link, frame: ring, with: {count: 12}}
  compass: {type: compass, parent: base_link, frame: compass}
outputs:
  mjcf: {file: mole.xml}
```

`mjcf` lists elements, each with one of these keys ([all keys](language.md#mjcf_element)):

- `sensor: gyro` stands in MuJoCo's list of sensors and measures at the frame of the sensor; with `xyz` or `rpy` at
  a site of its own in that frame, called `NAME_site`. Its attribute `site` is set (for `framepos` and the like
  `objtype` and `objname`); `attributes: {site: }` leaves it out.
- `body: camera` stands in the body of the frame, at `xyz` and `rpy`.
- `template: FILE` is a Jinja template beside the description, for what is more than an element: its text stands in
  the body, or with `section: asset` in that section of the file. It gets `robot`, `sensor`, `element` (with `name`,
  `link`, `pose` and `attributes`), `number` and `vector`.

`frame: optical` places an element in the optical frame; `frame: parent` puts it into the body of the link that the
sensor sits on. The element is called like the sensor, with `_` and its `name`. `replicate` makes copies, numbered
by MuJoCo: `NAME_0`, `NAME_1`, ... with as many digits as the count has.

Remember the axes: a rangefinder measures along z of its site, so `rpy: [0, 90 deg, 0]` makes it x of the frame; a
camera looks along -z with y up, so `rpy: [180 deg, 0, 0]` in the optical frame. Numbers are in SI units, but MuJoCo
counts the attribute `fovy` in degrees.

Which elements and attributes there are, MuJoCo knows; here only the form of the names is checked. A misspelt one is
reported by MuJoCo when it loads the model.

`gazebo` lists sensors in the words of SDF ([all keys](language.md#gazebo_sensor)); a URDF has them where its output
[asks for them](artifacts.md#sensors-for-gazebo). `sensor` is the type, `elements` are what stands in the `<sensor>`: a
mapping is an element with elements in it, a list is several of one name, what is empty is left out, and
`attributes: {type: gaussian}` gives an element attributes. The pose and the frame of its messages are written without a
word. A sensor of Gazebo looks along x of its frame with z up, so a camera has `frame: optical` and
`rpy: [90 deg, -90 deg, 0]`; `frame: joint` measures at the joint of the frame, and `feels: parent` names the shapes of
the link for a contact. Which elements there are, Gazebo knows; it takes a misspelt one without a word.

What no list has a word for stands under `urdf_elements`: elements of XML, at the end of the URDF.
"""


def text() -> str:
    """Return the page as it is committed."""
    lines = [_HEAD]
    for name, title in TITLES.items():
        file = Map.load(LIBRARY / f"{name}.yaml", f"{name}.yaml")
        lines += ["", f"## {title}", "", str(file["help"]).strip()]
        for part, body in file.get("parts", {}).items():
            lines += ["", f"### {name}/{part}", "", *_part(body)]
        for kind, body in file.get("sensor_types", {}).items():
            lines += ["", f"### {kind}", "", *_sensor_type(body)]
        if name == "solids":
            lines.append(_INERTIA.rstrip())
    return "\n".join([*lines, _OWN])


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
    return f"{kind} `{name}{numbered}`" + (" if asked for" if "if" in entry else "")


def _parameters(params: Mapping[str, Any]) -> Iterator[str]:
    """Yield the table of arguments."""
    yield "| argument | what it is | default | meaning |"
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
