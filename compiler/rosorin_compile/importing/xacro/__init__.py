"""Xacro expanded by the xacro library in a child process, then read as the URDF that came out.

To be read in this order: ``expanding`` (``is_xacro``, ``read_xacro``), then ``child``, the program of that process.
Nothing is imported here, because the child process imports this package too, and needs no reader.
"""
