"""Bags: what rosbag2 recorded, read raw in batches and put into a ``Recording``, cut ones too.

Read ``reading`` first, then ``topics`` (which are looked at), ``cdr`` (messages as numbers), ``clock``, ``cut`` and
``cut_mcap``.
"""
