"""rosorin-compile sweep: many robots of one description, each with arguments of its own.

To be read in this order: ``making`` (one variant), ``engines`` (who makes them: this process, several, a cluster),
``running`` (all of them in their order, with the index), ``report`` (what a person sees), ``command``.
"""
