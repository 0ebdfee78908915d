"""Show a robot: an interactive page (``view``), pictures (``picture``), and the tree of frames (``frames``)."""
