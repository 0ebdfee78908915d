"""Compile one description for many sets of arguments.

``variants`` reads the list, ``compiling`` compiles one variant, ``pool`` does so in processes or on a cluster,
``folder`` writes the results, ``command`` is ``rosorin-compile sweep``, ``library`` is ``rosorin_compile.sweep``.
"""
