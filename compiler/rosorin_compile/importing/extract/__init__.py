"""Numbers out of meshes: boxes and other shapes around parts, height maps, and all numbers of a factory package.

Meshes are read by trimesh, an optional dependency, into arrays of triangles (n, 3, 3) in metres. What cannot be done
is a diagnostic that ``ExtractProblem`` carries.

To be read in this order: ``command`` and ``options``; ``meshes`` and ``parts`` (triangles); ``boxes`` with ``fits``,
``measure`` and ``turning``; ``heightmap`` with ``grid``, and ``into``; ``factory``; ``writing`` (results as YAML and
JSON).
"""
