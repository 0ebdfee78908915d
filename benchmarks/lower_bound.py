"""The least that a Python program does to write the artifacts of a robot: load YAML by libyaml, format with ``%``.

``lower_bound.py DESCRIPTION OUTPUTS`` makes a template and a list of its numbers of each artifact, in the folder
``bound``; ``lower_bound.py DESCRIPTION`` loads the description and writes the artifacts from them.
"""

import json
import re
import sys
from pathlib import Path

import yaml

NUMBER = re.compile(r"-?\b\d+\.\d+\b")

bound = Path("bound")
if len(sys.argv) > 2:
    bound.mkdir(exist_ok=True)
    for path in Path(sys.argv[2]).iterdir():
        text = path.read_text("utf-8")
        (bound / f"{path.name}.template").write_text(NUMBER.sub("%s", text.replace("%", "%%")), "utf-8")
        (bound / f"{path.name}.numbers").write_text(json.dumps([float(one) for one in NUMBER.findall(text)]), "utf-8")
else:
    for path in sorted(Path(sys.argv[1]).rglob("*.yaml")):
        list(yaml.load_all(path.read_bytes(), yaml.CSafeLoader))
    for path in sorted(bound.glob("*.template")):
        numbers = json.loads(path.with_suffix(".numbers").read_bytes())
        text = path.read_text("utf-8") % tuple("%.8g" % number for number in numbers)  # noqa: UP031
        path.with_suffix("").write_text(text, "utf-8")
