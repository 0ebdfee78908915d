"""A robot to look at: the page with the robot in it, pictures of it, and the tree of its frames drawn.

Formats: ``page`` (HTML that needs nothing else) and ``frames_picture`` (the tree as SVG, Graphviz or Mermaid), which
``drawing`` draws, for terminals too. Commands: ``view``, ``picture`` and ``frames``.
"""
