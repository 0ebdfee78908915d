"""The keys of ``option`` of an MJCF output, as pieces of JSON Schema."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_SETTINGS: Mapping[str, tuple[Mapping[str, Any], str]] = {
    "integrator": ({"enum": ["Euler", "RK4", "implicit", "implicitfast"]}, "How time goes on."),
    "cone": ({"enum": ["pyramidal", "elliptic"]}, "The form of friction cones."),
    "jacobian": ({"enum": ["dense", "sparse", "auto"]}, "How the solver keeps its matrices."),
    "solver": ({"enum": ["PGS", "CG", "Newton"]}, "What solves for the forces of contacts and limits."),
    "timestep": ({"type": "number"}, "One step of time in s."),
    "impratio": ({"type": "number"}, "How hard friction is against normal forces."),
    **{
        f"{of}tolerance": ({"type": "number"}, f"When {what} is done.")
        for of, what in {"": "the solver", "ls_": "a line search", "noslip_": "noslip", "ccd_": "ccd"}.items()
    },
    "density": ({"type": "number"}, "Density of the air or water around, in kg/m^3."),
    "viscosity": ({"type": "number"}, "Viscosity of the air or water around, in Pa*s."),
    "o_margin": ({"type": "number"}, "Margin of all contacts in m, where contacts are overridden."),
    **{
        f"{of}iterations": ({"type": "integer"}, f"Most steps of {what}.")
        for of, what in {
            "": "the solver",
            "ls_": "a line search",
            "noslip_": "noslip",
            "ccd_": "ccd",
            "sdf_": "sdf",
        }.items()
    },
    "sdf_initpoints": ({"type": "integer"}, "Where sdf begins, how often."),
    **{
        word: ({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}, what)
        for word, what in {
            "gravity": "Gravity in m/s^2.",
            "wind": "Speed of the air in m/s.",
            "magnetic": "The magnetic field of the earth.",
        }.items()
    },
    "sleep_tolerance": ({"type": "number"}, "Below which speed in m/s or rad/s what is at rest may sleep."),
    **{
        f"o_{word}": (
            {"type": "array", "items": {"type": "number"}, "minItems": 1, "maxItems": count},
            f"{what} of all contacts, where contacts are overridden.",
        )
        for word, (count, what) in {
            "solref": (2, "Stiffness"),
            "solimp": (5, "Impedance"),
            "friction": (5, "Friction"),
        }.items()
    },
    "actuatorgroupdisable": (
        {"type": "array", "items": {"type": "integer"}},
        "The groups of actuators that are switched off.",
    ),
    "flag": (
        {"type": "object", "additionalProperties": {"enum": ["enable", "disable"]}},
        "What is computed, and what not.",
    ),
}
SETTINGS = {word: {**form, "description": what} for word, (form, what) in _SETTINGS.items()}
"""The settings of a simulation that a description has a word for: those of MuJoCo's <option>, in SI units."""
