"""A robot to look at: its page (``view``), pictures (``picture``), and the tree of its frames (``frames``)."""
