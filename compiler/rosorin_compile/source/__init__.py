"""The lowest layer of the package: files, YAML trees with source positions, units, diagnostics and plug-ins."""
