"""Distributions of ROS 2: those that artifacts can be written for, and the one whose facts are known for each."""

from __future__ import annotations

HUMBLE, JAZZY = "humble", "jazzy"

DISTRIBUTIONS = [HUMBLE, JAZZY, "kilted", "lyrical", "rolling"]


def described_by(distribution: str) -> str:
    """Return the distribution whose facts stand for another one: those after Jazzy are taken to be as it is.

    >>> described_by("humble"), described_by("rolling")
    ('humble', 'jazzy')
    """
    return HUMBLE if distribution == HUMBLE else JAZZY


def title(distribution: str) -> str:
    """Return a distribution as a sentence has it."""
    return distribution.capitalize()
