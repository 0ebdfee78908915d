"""XML: text to elements that know their places, and back.

To be read in this order: ``files`` (the text of a file), ``markup`` (elements of it, with places), ``elements``
(elements that are kept as text: whether they are whole, how they look, when two are the same).
"""
