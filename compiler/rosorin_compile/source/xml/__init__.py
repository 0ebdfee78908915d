"""XML: ``markup`` parses it with positions; ``elements`` handles elements that descriptions contain as text."""
