"""The language: from YAML to a robot. No rule of meaning, no format, no file is written here.

In the order of the data: ``expand`` (includes, arguments, parts, loops, and the ``expression`` in them), ``validate``
(the tree against the ``schema``), ``lower`` (the model), ``suppressions`` (problems that a description accepts).
"""
