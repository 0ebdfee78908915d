"""Factor repeated structures of an imported robot into parts.

``nodes`` makes links and joints comparable, ``parameters`` turns differences into parameters, and ``parts`` decides
what becomes a part and writes it.
"""

from .parts import with_parts

__all__ = ["with_parts"]
