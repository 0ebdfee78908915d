"""Tools: what stands beside the core, each in a folder: ``verify``, ``view``, ``picture``, ``sweep``, ``importer``, ...

``command`` is the command, and the rest what it works with. A tool uses the core as a package of others does.
"""
