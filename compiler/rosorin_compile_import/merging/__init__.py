"""Merging: a newer state of a source is imported again, into a description that somebody has worked on since.

To be read in this order: ``record`` (what the import before wrote is kept beside the description), ``three_way`` (what
was changed on both sides), ``editing`` (it is written where it stands), ``together`` (all files, and the proof that the
result is what the newer source says and the changes of its own, and nothing else), ``report``, ``reimport``.
"""
