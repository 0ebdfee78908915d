"""The type of the JSON result of collisions, from which its schema is generated."""

from typing import Any

from .matrix import CollisionMatrix

ANSWERS: dict[str, Any] = {"collisions": CollisionMatrix}
