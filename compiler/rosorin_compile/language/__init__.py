"""Convert a YAML description to a ``Robot``. Rules and output formats are in other packages.

The stages in order: ``expand`` evaluates includes, arguments, parts, loops and expressions; ``validate`` compares the
resulting tree with the ``schema``; ``lower`` builds the robot; ``suppressions`` applies the key ``accept``.
"""
