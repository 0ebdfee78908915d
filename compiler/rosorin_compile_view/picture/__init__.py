"""Pictures of a robot without a browser: the same camera, colours and light as the page of ``view``, by numpy alone.

``soup`` is what is drawn, ``camera`` from where, ``raster`` which surface a sample sees, ``light`` how it looks;
``painting`` makes pixels of that and ``png`` a file, ``svg`` a drawing of polygons.
"""
