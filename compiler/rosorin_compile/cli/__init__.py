"""The command line. Modules of commands use ``command`` (options), ``run`` (input) and ``console`` (output)."""
