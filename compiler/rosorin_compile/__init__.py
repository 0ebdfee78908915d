"""rosorin-compile: one description of a robot in YAML, and every artifact that other programs read."""

__version__ = "0.1.0"
