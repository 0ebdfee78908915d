"""Factor repeated structures of an imported robot into parts."""

from .parts import with_parts

__all__ = ["with_parts"]
