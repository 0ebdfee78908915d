"""The plain tree of a robot written as the YAML of a description, as a person would have written it.

To be read in this order: ``description`` (which file holds what), ``naming`` (values that get a name), ``numbers``,
``layout`` (how a value stands in YAML; its texts are those of ``yaml_text``), and ``remarks`` (where comments go).
"""

from __future__ import annotations

from .description import Outputs, outputs, tree_of, write

__all__ = ["Outputs", "outputs", "tree_of", "write"]
