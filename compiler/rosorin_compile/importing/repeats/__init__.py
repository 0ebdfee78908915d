"""Factor repeated structures of an imported robot into parts."""
