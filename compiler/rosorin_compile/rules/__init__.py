"""Rules: check a robot. A rule is a function that yields diagnostics; ``check`` runs all of them.

A rule relies on the shape of the tree and nothing else: the robot may have no link, two roots or a cycle. One cause
gives one message: where two rules see the same mistake, the later one ignores it.
"""
