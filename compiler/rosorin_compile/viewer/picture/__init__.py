"""Pictures of a robot without a browser: the camera, colours and light of the ``view`` page, by numpy alone.

``triangles`` turns shapes into triangles, ``render`` computes the pixels, ``labels`` draws frames and their names over
them, and ``draw`` writes the file.
"""
