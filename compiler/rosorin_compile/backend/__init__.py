"""What the tool's own packages take of the core beside its public names: no promise, and written down all the same.

A format that writes all of a robot asks more of it than a plug-in should have to know. These modules have the names, by
room; they only hand them on. Nothing of the core imports these modules.
"""
