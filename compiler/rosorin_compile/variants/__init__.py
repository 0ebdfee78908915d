"""Compile one description for many sets of arguments: ``rosorin-compile sweep``."""
