"""check parameters: the parameter files of a robot's nodes, held against its description.

``nodes`` are those that the files speak of, ``topics`` their topics and remaps, ``owners`` their transforms and frames.
"""
