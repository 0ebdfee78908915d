"""The type of the JSON result of sweep, from which its schema is generated."""

from typing import Any

from .writing import WrittenVariants

ANSWERS: dict[str, Any] = {"sweep": WrittenVariants}
