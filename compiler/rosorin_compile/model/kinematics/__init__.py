"""Kinematics: where frames sit in each other, for one state of the joints or for many at once.

``graph`` knows which frames hang together and through whose transforms, ``lookup`` composes one transform as tf2 does,
``Kinematics`` composes many with numpy. Only the last needs numpy, and imports it when it is made.
"""

from .batch import Kinematics
from .graph import Graph, Move, NoWay, Step

__all__ = ["Graph", "Kinematics", "Move", "NoWay", "Step"]
