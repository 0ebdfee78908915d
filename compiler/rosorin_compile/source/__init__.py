"""Files, YAML trees with source positions, units, diagnostics and plug-ins: the lowest layer of the package."""
