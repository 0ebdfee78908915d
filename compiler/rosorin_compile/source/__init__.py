"""Read YAML as a tree with the position of every value, and define the diagnostics that all stages return."""
