"""The commands, a module or folder each: ``options`` says what it takes, ``run`` does it and returns the exit code."""
