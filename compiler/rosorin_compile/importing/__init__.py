"""Importer: a robot that exists becomes a description, written as a person would have written it.

To be read in this order: ``command``, ``description`` (which file holds what, and which values get a name), ``repeats``
(what is there several times is written once), ``layout`` (how a value stands in YAML, and where comments go),
``round_trip`` (the description means what the source means), ``report`` (what the person is told).
"""
