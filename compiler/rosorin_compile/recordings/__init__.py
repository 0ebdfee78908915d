"""Compare recordings of a running robot with its description.

``bags`` and ``pasted`` read messages into a ``Recording``; ``expected`` lists the edges that the description calls for;
``judge`` and ``judge_edges`` compare the two and yield findings; ``results`` shows them.
"""
