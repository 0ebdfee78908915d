"""A fleet is checked as one: the robots of a ``sweep.json``, which numbers differ between them, and which are typos.

To be read in this order: ``sweep_file`` (the file, line by line), ``columns`` (the numbers of all robots, by their
meaning), ``spread`` (one number over the robots, and what is far from the others), ``judging`` (which numbers come from
which argument, and what is said of outliers), ``report`` (the table), ``page`` and ``command``.
"""
