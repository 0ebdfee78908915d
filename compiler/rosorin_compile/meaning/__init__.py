"""Meaning: two robots held against each other, whatever they were written in.

``robots`` compares two of them (``diff``), ``golden`` the committed artifacts with those just compiled (``check``), and
``agreement`` all artifacts of one robot. ``wording``, ``solids`` and ``tolerance`` are what they share.
"""
