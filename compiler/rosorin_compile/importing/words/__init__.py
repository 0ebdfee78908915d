"""Words: what a URDF says beside links and joints becomes sections of a description, where those say the same.

To be read in this order: ``taking`` (which elements may become which entries), ``blocks``, ``sensors`` and ``drives``
(one element as an entry), ``meaning`` (when two elements say the same), ``proving`` (what an entry becomes is held
against the element that it came from), ``report`` (what became of each).
"""

from __future__ import annotations

from .proving import Worded, worded

__all__ = ["Worded", "worded"]
