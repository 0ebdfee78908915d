"""Rules that check a robot. A rule is a function that yields diagnostics; ``check`` runs all of them.

A rule may rely on the schema only: the robot may have no link, two roots or a cycle. Each mistake is reported once: if
two rules can find it, the later one ignores it.
"""
