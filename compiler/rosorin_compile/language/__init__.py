"""The language: from YAML to a robot. This package defines no semantic rules and no formats, and writes no files.

The stages in order: ``expand`` (includes, arguments, parts, loops, and the ``expression`` in them), ``validate``
(the tree against the ``schema``), ``lower`` (the model), ``suppressions`` (problems that a description accepts).
"""
