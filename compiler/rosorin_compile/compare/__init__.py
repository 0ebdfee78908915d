"""Two robots, or one artifact before and after, compared leaf by leaf (``walk``), and what differs in words."""
