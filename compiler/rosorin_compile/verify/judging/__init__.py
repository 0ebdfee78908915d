"""Judging: what was kept of a recording held against what is expected, as findings.

Read ``judge`` first, which asks the others in this order: ``edges``, ``tree``, ``joints``, ``sensors``, ``text``.
"""
