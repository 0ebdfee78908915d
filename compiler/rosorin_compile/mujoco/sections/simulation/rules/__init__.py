"""Rules of what only a simulation has.

``rules.simulated`` says whether what is named is there; the modules here say whether actuators, tendons,
constraints and sensors have what MuJoCo needs of them and no more, and ``numbers`` whether numbers are in order.
"""
