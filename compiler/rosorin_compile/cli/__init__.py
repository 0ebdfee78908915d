"""The command line: modules of commands, which use ``command`` (options), ``run`` (input) and ``console`` (output)."""
