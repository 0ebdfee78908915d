"""Explain: where a frame sits, and where each number that puts it there was written (``answer``)."""
