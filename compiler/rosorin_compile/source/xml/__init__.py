"""XML: ``files`` reads the text, ``markup`` makes elements with places of it, ``elements`` is for XML kept as text."""
