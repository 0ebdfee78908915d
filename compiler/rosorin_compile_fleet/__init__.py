"""Many robots: one description compiled for many sets of arguments, and robots that are held against each other.

``sweep`` makes them. ``check`` looks at all of them at once: what one has alone is a typo, or a discovery.
"""
