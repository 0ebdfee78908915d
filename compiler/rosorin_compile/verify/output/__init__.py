"""Output: a verdict as people and machines read it.

Read ``lines`` first (the text on the terminal), then ``machine`` (JSON and JUnit XML) and ``picture`` (SVG).
"""
