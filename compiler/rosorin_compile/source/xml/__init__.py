"""XML: ``markup`` reads it, with places; ``elements`` is for elements that are kept as text."""
