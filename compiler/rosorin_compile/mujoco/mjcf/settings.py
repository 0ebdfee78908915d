"""The keys of ``option`` of an MJCF output, as pieces of JSON Schema."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_SOLVERS = {"": "the solver", "ls_": "a line search", "noslip_": "noslip", "ccd_": "ccd"}
_NUMBER, _COUNT, _NUMBERS = {"type": "number"}, {"type": "integer"}, {"type": "array", "items": {"type": "number"}}
_VECTOR = {**_NUMBERS, "minItems": 3, "maxItems": 3}
_OVERRIDDEN = {"solref": (2, "Stiffness"), "solimp": (5, "Impedance"), "friction": (5, "Friction")}
_SETTINGS: Mapping[str, tuple[Mapping[str, Any], str]] = {
    "integrator": ({"enum": ["Euler", "RK4", "implicit", "implicitfast"]}, "How time goes on."),
    "cone": ({"enum": ["pyramidal", "elliptic"]}, "The form of friction cones."),
    "jacobian": ({"enum": ["dense", "sparse", "auto"]}, "How the solver keeps its matrices."),
    "solver": ({"enum": ["PGS", "CG", "Newton"]}, "What solves for the forces of contacts and limits."),
    "timestep": (_NUMBER, "One step of time in s."),
    "impratio": (_NUMBER, "How hard friction is against normal forces."),
    **{f"{of}tolerance": (_NUMBER, f"When {what} is done.") for of, what in _SOLVERS.items()},
    "density": (_NUMBER, "Density of the air or water around, in kg/m^3."),
    "viscosity": (_NUMBER, "Viscosity of the air or water around, in Pa*s."),
    "o_margin": (_NUMBER, "Margin of all contacts in m, where contacts are overridden."),
    **{f"{of}iterations": (_COUNT, f"Most steps of {what}.") for of, what in {**_SOLVERS, "sdf_": "sdf"}.items()},
    "sdf_initpoints": (_COUNT, "Where sdf begins, how often."),
    "gravity": (_VECTOR, "Gravity in m/s^2."),
    "wind": (_VECTOR, "Speed of the air in m/s."),
    "magnetic": (_VECTOR, "The magnetic field of the earth."),
    "sleep_tolerance": (_NUMBER, "Below which speed in m/s or rad/s what is at rest may sleep."),
    **{
        f"o_{word}": (
            {**_NUMBERS, "minItems": 1, "maxItems": count},
            f"{what} of all contacts, where contacts are overridden.",
        )
        for word, (count, what) in _OVERRIDDEN.items()
    },
    "actuatorgroupdisable": ({"type": "array", "items": _COUNT}, "The groups of actuators that are switched off."),
    "flag": (
        {"type": "object", "additionalProperties": {"enum": ["enable", "disable"]}},
        "What is computed, and what not.",
    ),
}
SETTINGS = {word: {**form, "description": what} for word, (form, what) in _SETTINGS.items()}
"""The settings of a simulation that a description has a word for: those of MuJoCo's <option>, in SI units."""
