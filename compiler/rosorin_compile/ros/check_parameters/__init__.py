"""check parameters: the parameter files of a robot's nodes, held against its description.

``nodes`` are those that the files speak of, ``remaps`` move their topics, ``owners`` compares transforms and frames.
"""
