"""Text: what people paste from a terminal, put into a ``Recording``.

Read ``plain_lines`` first (a text without what surrounds its lines), then ``reading``, which tells apart what may
follow one another: answers of tf2_echo (``echo``), trees of view_frames (``frames``), ros2 topic echo (``topics``).
"""
