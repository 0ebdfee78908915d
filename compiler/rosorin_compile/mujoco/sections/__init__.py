"""The sections of the language that only a simulation has."""
