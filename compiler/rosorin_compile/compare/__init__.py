"""Compare two robots, or two versions of an artifact, value by value (``walk``), and describe the differences."""
