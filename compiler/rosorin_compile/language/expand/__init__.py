"""Expand a description to a plain tree without includes, arguments, expressions, parts, loops and conditions.

Read the modules in this order: ``description`` (the entry point), ``files`` (includes), ``declarations`` (parameters),
``scope`` (names and their values), ``parts`` with ``placing``, and ``included_robots``.
"""
