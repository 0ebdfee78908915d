"""The command line: one module per command, with ``command`` (options), ``run`` and ``answer`` as their base."""
