"""Meaning: two robots held against each other, whatever they were written in.

``proof`` says whether what was made of a robot is that robot. Where two are to be told apart for a person, ``diff``
compares two robots, and ``committed`` the committed artifacts with those just compiled (``check``). ``wording``,
``solids`` and ``tolerance`` are what they share.
"""
