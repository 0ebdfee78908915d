"""Sections of the language, each in a folder of its own: schema, value, lowering, rules, comparison.

The record of one is in its ``__init__``; ``shipped`` names them. What only a function needs is named there as text, and
imported when it is called.
"""
