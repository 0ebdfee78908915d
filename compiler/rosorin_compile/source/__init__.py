"""From YAML text to a tree with positions, and the diagnostics that every stage reports."""
