"""URDF read into the plain tree; what urdfdom refuses is refused.

To be read in this order: ``robot`` (the file as a whole), ``reading`` and ``values`` (how one element and its numbers
are taken apart), then ``links``, ``joints``, ``materials`` and ``poses``. ``spelling``, ``verbatim`` and ``remarks``
look after misspelt words, after what the language has no word for, and after comments.
"""

from __future__ import annotations

from .robot import read_urdf

__all__ = ["read_urdf"]
