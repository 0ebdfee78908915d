"""Frontend: from YAML to a robot. No rule of meaning, no format, no file is written here.

To be read in the order of the data: ``load`` (YAML to a ``tree`` that knows its lines), ``expand`` (includes,
arguments, parts, loops, and the ``expression`` in them), ``validate`` (the tree against the ``schema``), ``lower``
(the model), ``accepting`` (what a robot may break all the same).

Helpers: ``written`` (what the files contained before anything was evaluated), ``source.yaml_text`` (text as YAML writes
it), ``arguments`` and ``asked`` (what the command line and the Python API are given).
"""
