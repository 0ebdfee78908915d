"""The plain tree of a robot written as the YAML of a description, as a person would have written it.

To be read in this order: ``command``, ``description`` (which file holds what, and which values get a name), ``layout``
(how a value stands in YAML, and where comments go; its texts are those of ``yaml_text``), and ``prove`` (both mean the
same).
"""
