"""Compile YAML to a robot. This package has no semantic rules and no formats, and writes no files.

The stages in order: ``expand`` evaluates includes, arguments, parts, loops and expressions; ``validate`` compares the
resulting tree with the ``schema``; ``lower`` builds the robot; ``suppressions`` applies the key ``accept``.
"""
