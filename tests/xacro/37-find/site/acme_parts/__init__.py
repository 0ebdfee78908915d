"""A package of parts, as others install them."""
