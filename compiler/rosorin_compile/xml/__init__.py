"""XML: text to elements that know their places, and back.

``files`` reads the text, ``markup`` makes elements of it, ``elements`` is about elements that are kept as text.
"""
