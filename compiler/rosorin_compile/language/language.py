"""Language: the words of the language as data, of which reference pages and the schema for editors are made."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rosorin_compile.source import rule_registry as registry
from rosorin_compile.source.rule_registry import Rule
from rosorin_compile.source.units import DIMENSIONS, UNITS, describe, parse_unit

from .accepting import STAYS
from .annotations import ANNOTATIONS
from .authoring import for_editors
from .authoring.added import added_definitions, added_sections, definitions
from .expand.placing import AXES
from .expression import CONSTANTS
from .expression.functions import BUILT_IN
from .schema import of_parts, of_types, with_formats

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

# The topics of what is said of a robot while it is compiled.
_COMPILING = (
    *(registry.FILES, registry.ARGUMENTS, registry.SHAPE, registry.JOINTS, registry.NUMBERS, registry.POSES),
    *(registry.FRAMES, registry.OUTPUTS, registry.FORMATS, registry.SIMULATION, registry.PHYSICS),
)


@dataclass(frozen=True)
class Language:
    """What a description may say.

    ``schema`` has the options of outputs of all formats; ``annotations`` are its words that only the compiler reads.
    ``in_types`` are the keys of a sensor that a type of sensors may say. ``functions`` and ``units`` have what is said
    of each in the reference, ``types`` those of arguments that are quantities. ``acceptable`` are the rules that
    ``accept`` may name.
    """

    schema: Mapping[str, Any]
    annotations: frozenset[str]
    in_parts: tuple[str, ...]
    in_types: tuple[str, ...]
    mirrors: tuple[str, ...]
    constants: tuple[str, ...]
    functions: Mapping[str, str]
    units: Mapping[str, str]
    types: Mapping[str, str]
    acceptable: tuple[str, ...]

    @classmethod
    def of(cls, formats: Iterable[Format]) -> Language:
        """Return the language with some formats."""
        return cls(
            schema=with_formats(formats),
            annotations=ANNOTATIONS,
            in_parts=of_parts(),
            in_types=of_types(),
            mirrors=tuple(AXES),
            constants=tuple(CONSTANTS),
            functions={one.name: one.help for one in BUILT_IN},
            units={name: describe(dimension) for name, (_, dimension) in UNITS.items()},
            types={name: describe(dimension) for name, dimension in DIMENSIONS.items()},
            acceptable=tuple(sorted(rule.id for rule in Rule.every() if _is_acceptable(rule))),
        )

    def authoring(self) -> dict[str, Any]:
        """Return the schema of descriptions as people write them, for editors."""
        return for_editors(self)

    def added(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the sections and the definitions of files that descriptions have no more: parts, uses, ..."""
        sections = self.schema["properties"]
        inner = added_definitions(self, sections, self.schema["$defs"]["arg"])
        return added_sections(sections), {**definitions(self), **inner}

    def is_unit(self, unit: str) -> bool:
        """Say whether a text is a unit, a simple or a compound one."""
        return parse_unit(unit) is not None

    def units_for(self, unit: str) -> list[str]:
        """Return the units in which a quantity of a unit may be written, by their dimension: for m also mm."""
        parsed = parse_unit(unit)
        return [name for name, (_, dimension) in UNITS.items() if parsed is not None and dimension == parsed[1]]


def _is_acceptable(rule: Rule) -> bool:
    is_told = bool(rule.asked) or rule.topic in _COMPILING
    return is_told and (bool(rule.accept) or rule.mild) and rule.id not in STAYS
