"""Verdict: what came out of holding a recording against a description."""

from __future__ import annotations

from typing import NamedTuple

from ..diagnostic import ERROR, WARNING, Diagnostic
from .expected import Description
from .recording.recording import Recording


class Verdict(NamedTuple):
    """A recording, what it was held against, and the findings, the most serious first."""

    recording: Recording
    description: Description
    findings: list[Diagnostic]

    def count(self, severity: str) -> int:
        """Return how many findings are of a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    def fails(self, strict: bool = False) -> bool:
        """Whether the robot that ran is not the one that is described; ``strict`` takes warnings for errors."""
        return bool(self.count(ERROR) or (strict and self.count(WARNING)))
