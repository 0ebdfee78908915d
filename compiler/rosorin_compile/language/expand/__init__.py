"""Expansion: includes, arguments, named values, expressions, parts, loops and conditions; the result is one plain tree.

Read in this order: ``description``, ``files`` (what is included), ``declarations`` (parameters), ``scope`` (names and
their values), ``parts`` with ``placing``, ``included_robots``.
"""
