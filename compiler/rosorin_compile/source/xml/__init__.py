"""Parse XML with source positions (``markup``), and handle XML elements that are stored as strings (``elements``)."""
