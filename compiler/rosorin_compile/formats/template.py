"""template: an artifact of the user's own, from a Jinja template beside the description and one line of YAML.

    outputs:
      srdf: {file: my_robot.srdf, backend: template, template: my_robot.srdf.jinja}

``docs/artifacts.md`` lists the names that a template gets (``_names``). Templates run in Jinja's sandbox; a name that
does not exist is an error, and values in a template for XML, by its file name, are escaped.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rosorin_compile.model import Output, Robot
from rosorin_compile.source.diagnostics import Diagnostic, error
from rosorin_compile.source.numbers import NumberFormat, exact, fixed, short, six, vector
from rosorin_compile.source.rule_registry import TEMPLATES, Rule

from .format import Format
from .static_tf import describe
from .templating import Templates

RULES = (
    Rule(
        "template-not-named",
        "The backend `template` has no `template`.",
        "Name a file beside the description.",
        TEMPLATES,
    ),
)


def write(robot: Robot, output: Output, templates: Templates) -> tuple[str, list[Diagnostic]]:
    """Return what the template of an output makes of a robot. Raises TemplateProblem."""
    name = output.options.get("template")
    if not name:
        message = f'output "{output.name}" names no template'
        return "", [error("template-not-named", message, None, "add template: FILE, a Jinja template")]
    return templates.render(name, _names(robot, output)), []


def _names(robot: Robot, output: Output) -> dict[str, Any]:
    return {
        "robot": robot,
        "output": output,
        "number": short,
        "exact": exact,
        "six": six,
        "fixed": fixed,
        "vector": _vector,
        "degrees": math.degrees,
        "radians": math.radians,
        "kind": _kind,
        "source": describe,
    }


def _vector(numbers: Sequence[float], number: NumberFormat = short) -> str:
    return vector(numbers, number)


def _kind(geometry: object) -> str:
    return type(geometry).__name__


FORMAT = Format(
    name="template",
    word="artifact of a template",
    article="an",
    rank=900,
    options={
        "template": {
            "type": "string",
            "description": "A Jinja template in the folder of the description, for an artifact of your own.",
        },
        "options": {"type": "object", "description": "Values of your own, reached as output.options.options."},
    },
    write=write,
)
