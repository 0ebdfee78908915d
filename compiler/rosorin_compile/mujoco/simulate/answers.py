"""The type of the JSON result of simulate, from which its schema is generated."""

from typing import Any

from .simulation import Simulated

ANSWERS: dict[str, Any] = {"simulate": Simulated}
