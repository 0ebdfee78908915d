"""The type of the result of import, from which its schema is made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Any

from .import_robot import ImportResult

ANSWERS: dict[str, Any] = {"import": ImportResult}
