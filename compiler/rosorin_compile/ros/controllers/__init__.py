"""controllers.yaml: the parameters of ros2_control's controller_manager and of its controllers.

``filled`` makes the text of ``controllers`` in a description and of what the robot knows (``derived``), ``checking``
holds parameters against the robot: those of a description (``described``), and those of files (``check_parameters``).
"""

from __future__ import annotations

from rosorin_compile.formats.format import Unsupported

from ..parameters import parameter_file
from .described import check
from .filled import view, write

__all__ = ["FORMAT"]


_UNSUPPORTED = {"controllers.*.inactive": Unsupported("the launch file of a package starts it so", quiet=True)}

FORMAT = parameter_file(
    "controllers",
    word="controllers.yaml",
    about="the parameters of ros2_control's controllers",
    rank=61,
    covers=("robot", "controllers", "drive"),
    unsupported=_UNSUPPORTED,
    file="controllers.yaml",
    check=check,
    write=write,
    view=view,
)
