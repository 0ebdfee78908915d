"""Numbers from meshes: shapes around parts, height maps, and the numbers of a ROS description package.

Meshes are arrays of triangles (n, 3, 3) in metres. What cannot be done is a diagnostic in an ``ExtractProblem``.
"""
