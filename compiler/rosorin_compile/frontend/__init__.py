"""Frontend: from YAML to a robot.

To be read in the order of the data: ``load`` (YAML to a ``tree`` that knows its lines), ``expand`` (includes,
arguments, expressions), ``validate`` (the JSON Schema), ``lower`` (the model), ``accepting`` (what may be
all the same).
"""
