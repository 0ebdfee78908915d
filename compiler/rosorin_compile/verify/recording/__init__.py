"""Recording: what is kept of a recording while it streams by, in statistics whose size does not grow with it.

Read ``recording`` first, which has all of it, then ``series`` (one edge), ``joints`` and ``reference`` (where moving
edges should be), ``pace`` (when messages came), ``leaps`` (what tells of two sources) and ``sensors``.
"""
