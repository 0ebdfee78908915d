"""Compile one description for many sets of arguments; see ``command`` and ``library``."""
