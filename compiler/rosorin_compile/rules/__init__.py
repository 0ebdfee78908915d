"""Rules that check a robot. A rule is a function that yields diagnostics; ``check`` runs all of them.

A rule can only assume that the description matches the schema: the robot may have no link, two roots or a cycle. If two
rules can detect the same mistake, only the first rule reports it.
"""
