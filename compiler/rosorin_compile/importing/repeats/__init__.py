"""Move repeated structures of an imported robot into reusable parts."""
