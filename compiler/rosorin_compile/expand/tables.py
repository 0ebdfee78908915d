"""Tables: YAML files of plain values that expressions look things up in, with ``load("calibration.yaml")``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..expression.functions import ExpressionError
from ..load import LoadError, parse_yaml, read_text
from ..paths import shown
from .files import Reader


def table_loader(reader: Reader) -> Callable[[Any], Any]:
    """Return the function ``load`` of a description: the value of a YAML file inside its folder, read once."""
    loaded: dict[str, Any] = {}

    def load(name: Any) -> Any:
        if not isinstance(name, str):
            raise ExpressionError("load takes the name of a YAML file")
        if name not in loaded:
            path = reader.folder / name
            if not reader.inside(path):
                raise ExpressionError(f"{name} is outside the folder of the description")
            reader.files.append(path)
            try:
                loaded[name] = parse_yaml(read_text(path, shown(path)))
            except LoadError as problem:
                found = problem.diagnostic
                where = f" ({found.span.source.path}:{found.span.line}:{found.span.column})" if found.span else ""
                raise ExpressionError(f"{found.message}{where}", help=found.help) from None
        return loaded[name]

    return load
