"""What makes a start cheap: the user's cache, the same command said again, and what was worked out.

The modules here import nothing of the compiler, and of Python little that it has not loaded anyway.
"""
