"""The commands, one module each: ``options`` says what it takes, ``run`` does it and returns the exit code."""
