"""check parameters: the ``nodes`` of parameter files, their ``transforms``, and all that ``check`` compares."""
