"""Explain: where a frame sits, and where each number that puts it there was written.

To be read in this order: ``command``, ``answer`` (the question taken apart), ``frames`` (the way to a frame, and what
a link has), ``origins`` (where a number was written), ``values`` (what an answer is made of), ``text`` (it as lines).
"""
