"""Verify: recordings of a running robot held against its description.

The way of the data: ``sources`` tells what a source is; ``bags`` and ``text`` read it into a ``Recording``, which keeps
statistics of fixed size; ``judge`` holds that against what is ``expected`` and returns findings; ``lines``, ``machine``
and ``picture`` show them.
"""

from __future__ import annotations

from .expected import Options
from .findings import Finding
from .sources import verify
from .verdict import Verdict

__all__ = ["Finding", "Options", "Verdict", "verify"]
