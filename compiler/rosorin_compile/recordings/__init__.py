"""Compare recordings of a running robot with its description.

``bags`` and ``pasted`` read messages into a ``Recording``; ``expected`` lists the edges that the description calls for;
the modules named ``judge`` compare the two and yield findings; ``report`` and ``picture`` show them.
"""
