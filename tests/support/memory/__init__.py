"""A world that changes step by step, and a program that asks it: answered with memory and without."""
