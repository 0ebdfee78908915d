"""How a foreign robot is read: what `import`, `include` and `diff` can say about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..diagnostic import Diagnostic


@dataclass(frozen=True)
class ReadOptions:
    """What is said beside the file itself.

    ``arguments`` are those of a xacro file, texts by name. ``packages`` are folders of ROS packages by name, asked
    before any other place. ``lenient`` takes what breaks the specification where a robot comes out all the same.
    ``environment`` are the environment variables; None means those of this process.
    ``tell`` takes what has to be said before anything is run (``xacro-runs-code``), at that moment; what it was told is
    not among the diagnostics. Without it, that is the first of them.
    ``checked`` asks for the meaning to be held against the rules. The round trip, which reads what the compiler has
    just written, does without: those of its source are settled.
    """

    arguments: Mapping[str, str] = field(default_factory=dict)
    packages: Mapping[str, Path] = field(default_factory=dict)
    lenient: bool = False
    environment: Mapping[str, str] | None = None
    tell: Callable[[Diagnostic], None] | None = None
    checked: bool = True
