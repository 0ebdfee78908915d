"""simulate: the robot in MuJoCo, and how it behaves there.

``command`` goes through it. ``world`` has the robot on a floor or held, its actuators, and time going on in steps that
are watched; ``trials`` lets it rest, hold poses, drive, sweep its joints and swing; ``judging`` holds what came of that
against limits, and says it as diagnostics; ``report`` has the tables, the JSON, and the page with the curves.
"""
