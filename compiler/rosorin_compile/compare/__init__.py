"""Compare two robots, or two versions of an artifact, leaf by leaf (``walk``), and describe the differences."""
