"""The command line: commands, with ``command`` (options), ``run`` and ``console`` (output) as their base."""
